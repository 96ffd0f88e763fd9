#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>
#include <random>

#include "io/test_files.h"
#include "planegraph/io/cloud_io.h"
#include "planegraph/io/cloud_writer.h"

namespace planegraph {
namespace {

using PlyPositionsTest = TestFolder;
constexpr std::size_t kSeveralBlocks = 40001;

Cloud RandomCloud(std::size_t count) {
  std::mt19937 engine(3);
  std::uniform_real_distribution<float> uniform(-50.0f, 50.0f);
  Cloud cloud;
  cloud.offset = {431000, 5.4e6, 112};
  cloud.viewpoint = {431001, 5.4e6 + 2, 113};
  for (std::size_t i = 0; i < count; ++i) {
    cloud.points.emplace_back(uniform(engine), uniform(engine), uniform(engine));
    cloud.colors.push_back({1, 2, static_cast<std::uint8_t>(i)});
    cloud.normals.push_back(Eigen::Vector3f::UnitZ());
    cloud.intensities.push_back(uniform(engine));
  }
  return cloud;
}

// What is read is what ReadCloud gives, without the attributes.
void ExpectPositionsOf(const std::string& path, const std::string& format) {
  const Cloud whole = ReadCloud(path, format), positions = ReadPositions(path, format);
  EXPECT_EQ(positions.points, whole.points);
  EXPECT_EQ(positions.offset, whole.offset);
  EXPECT_EQ(positions.viewpoint, whole.viewpoint);
  EXPECT_TRUE(positions.normals.empty() && positions.colors.empty() &&
              positions.intensities.empty());
}

TEST_F(PlyPositionsTest, AreThoseOfTheCloudInAllFormats) {
  const Cloud cloud = RandomCloud(kSeveralBlocks);
  for (const std::string ending : {"ply", "pcd", "xyz"}) {
    SCOPED_TRACE(ending);
    WriteCloud(Path("cloud." + ending), cloud);
    ExpectPositionsOf(Path("cloud." + ending), ending);
    ExpectPositionsOf(Path("cloud." + ending), "auto");
  }
  EXPECT_EQ(ReadPositions(Path("cloud.ply"), "ply").points, cloud.points);
}

TEST_F(PlyPositionsTest, OfAMap) {
  const Cloud cloud = RandomCloud(kSeveralBlocks);
  MapPlyWriter writer(Path("map.ply"), cloud.offset);
  for (const auto& point : cloud.points) writer.Add(point, {9, 8, 7}, PointSource::kLaser, 4, -1);
  writer.Commit();
  ExpectPositionsOf(Path("map.ply"), "ply");
  EXPECT_EQ(ReadPositions(Path("map.ply"), "ply").points, cloud.points);
}

TEST_F(PlyPositionsTest, PointsThatAreNotFiniteAreDropped) {
  Cloud cloud = RandomCloud(kSeveralBlocks);
  for (const std::size_t i : {0, 16383, 16384, 40000}) {
    cloud.points[i].y() = std::numeric_limits<float>::quiet_NaN();
  }
  WriteCloud(Path("cloud.ply"), cloud);
  ExpectPositionsOf(Path("cloud.ply"), "ply");
  EXPECT_EQ(ReadPositions(Path("cloud.ply"), "ply").size(), kSeveralBlocks - 4);
}

TEST_F(PlyPositionsTest, OtherFormsOfPlyToo) {
  const std::string body = Bytes(1.0) + Bytes(2.0f) + Bytes(3.0f) + std::string(1, '\x05');
  const std::string properties =
      "element vertex 1\nproperty double x\nproperty float y\nproperty float z\n"
      "property uchar red\nend_header\n";
  const std::string head = "ply\nformat binary_little_endian 1.0\ncomment offset 1 2 3\n";
  ExpectPositionsOf(Write("wide.ply", head + properties + body), "ply");
  ExpectPositionsOf(Write("ascii.ply", "ply\nformat ascii 1.0\ncomment offset 1 2 3\n" +
                                           properties + "1 2 3 4\n"),
                    "ply");
  ExpectPositionsOf(Write("first.ply", head + "element camera 1\nproperty uchar id\n" + properties +
                                           std::string(1, 'c') + body),
                    "ply");
}

TEST_F(PlyPositionsTest, DamagedFilesGiveTheSameErrors) {
  WriteCloud(Path("cloud.ply"), RandomCloud(100));
  const std::string good = ReadTextFile(Path("cloud.ply"));
  std::string huge = good;
  huge.replace(huge.find("element vertex 100"), 18, "element vertex 18446744073709551615");
  std::string unknown = good;
  unknown.replace(unknown.find("float x"), 7, "fload x");
  const std::string no_elements =
      "ply\nformat binary_little_endian 1.0\ncomment offset 1 2 3\nend_header\n";
  for (const std::string& bytes :
       {good.substr(0, good.size() - 1), good.substr(0, good.size() / 2), good.substr(0, 60), huge,
        unknown, no_elements, std::string("ply\n"), std::string()}) {
    const std::string path = Write("damaged.ply", bytes);
    const std::string expected = ErrorOf([&] { ReadCloud(path, "ply"); });
    EXPECT_NE(expected, "none");
    EXPECT_EQ(ErrorOf([&] { ReadPositions(path, "ply"); }), expected);
  }
  EXPECT_EQ(ErrorOf([&] { ReadPositions(Path("absent.ply"), "ply"); }),
            ErrorOf([&] { ReadCloud(Path("absent.ply"), "ply"); }));
}

}  // namespace
}  // namespace planegraph
