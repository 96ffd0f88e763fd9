#include "planegraph/io/cloud_io.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>

#include "io/test_files.h"
#include "planegraph/io/cloud_writer.h"

namespace planegraph {
namespace {

using testing::HasSubstr;

Cloud RandomCloud(std::size_t n, bool attributes) {
  std::mt19937 rng(5);
  std::normal_distribution<float> normal(0.0f, 20.0f);
  std::uniform_int_distribution<int> channel(0, 255);
  Cloud cloud;
  for (std::size_t i = 0; i < n; ++i) {
    cloud.points.emplace_back(normal(rng), normal(rng), normal(rng));
    if (!attributes) continue;
    cloud.normals.push_back(Eigen::Vector3f(normal(rng), normal(rng), normal(rng)).normalized());
    cloud.colors.push_back({static_cast<std::uint8_t>(channel(rng)),
                            static_cast<std::uint8_t>(channel(rng)),
                            static_cast<std::uint8_t>(channel(rng))});
    cloud.intensities.push_back(normal(rng));
  }
  return cloud;
}

void ExpectSame(const Cloud& a, const Cloud& b) {
  EXPECT_EQ(a.offset, b.offset);
  EXPECT_EQ(a.viewpoint, b.viewpoint);
  EXPECT_EQ(a.points, b.points);
  EXPECT_EQ(a.normals, b.normals);
  EXPECT_EQ(a.colors, b.colors);
  EXPECT_EQ(a.intensities, b.intensities);
}

class CloudIo : public TestFolder {
 protected:
  // The message of the InputError that reading gives.
  std::string ErrorOf(const std::string& path, const std::string& format = "auto") {
    try {
      ReadCloud(path, format);
    } catch (const InputError& error) {
      EXPECT_EQ(error.file(), path);
      return error.what();
    }
    return "(no error)";
  }
};

TEST_F(CloudIo, EveryFormatComesBackBitForBit) {
  for (const char* name : {"a.ply", "a.pcd", "a.xyz", "A.PLY", "a.txt"}) {
    for (const bool attributes : {false, true}) {
      Cloud cloud = RandomCloud(1000, attributes);
      cloud.points[3] = {1e-30f, -3.4e4f, 0.1f};
      cloud.viewpoint = {1.25, -2.5, 1.75};
      WriteCloud(Path(name), cloud);
      ExpectSame(ReadCloud(Path(name)), cloud);
      cloud.offset = {393123.0, 5707456.5, 112.25};
      cloud.viewpoint = cloud.offset;
      WriteCloud(Path(name), cloud);
      ExpectSame(ReadCloud(Path(name)), cloud);
    }
  }
}

TEST_F(CloudIo, LargeFilesAreWrittenInBlocks) {
  const Cloud cloud = RandomCloud(150001, true);
  std::vector<std::int32_t> plane(cloud.size(), -1);
  WriteCloud(Path("a.ply"), cloud, {{"plane", plane}, {"scan", plane}});
  ExpectSame(ReadCloud(Path("a.ply")), cloud);
  WriteCloud(Path("a.pcd"), cloud, {{"plane", plane}});
  ExpectSame(ReadCloud(Path("a.pcd")), cloud);
}

TEST_F(CloudIo, IntPropertiesAreInTheFile) {
  Cloud cloud;
  cloud.points = {{1, 2, 3}, {4, 5, 6}};
  WriteCloud(Path("a.ply"), cloud, {{"plane", {7, -1}}});
  const std::string text = ReadTextFile(Path("a.ply"));
  EXPECT_THAT(text, HasSubstr("property int plane\nend_header\n"));
  EXPECT_EQ(text.substr(text.size() - 4), Bytes<std::int32_t>(-1));
  EXPECT_EQ(text.substr(text.size() - 20, 4), Bytes<std::int32_t>(7));
  WriteCloud(Path("a.xyz"), cloud, {{"plane", {7, -1}}});
  EXPECT_THAT(ReadTextFile(Path("a.xyz")), HasSubstr("# x y z plane\n1 2 3 7\n4 5 6 -1\n"));
  EXPECT_THROW(WriteCloud(Path("a.ply"), cloud, {{"plane", {7}}}), std::invalid_argument);
  EXPECT_THROW(WriteCloud(Path("a.stl"), cloud), InputError);
  EXPECT_THROW(WriteCloud(Path("none/a.ply"), cloud), InputError);
}

TEST_F(CloudIo, NonFinitePointsGoWithTheirAttributes) {
  constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
  constexpr float kInf = std::numeric_limits<float>::infinity();
  Cloud cloud = RandomCloud(5, true);
  Cloud expected = cloud;
  for (auto* field : {&expected.points, &expected.normals}) {
    field->erase(field->begin() + 3);
    field->erase(field->begin() + 1);
  }
  expected.colors = {cloud.colors[0], cloud.colors[2], cloud.colors[4]};
  expected.intensities = {cloud.intensities[0], cloud.intensities[2], cloud.intensities[4]};
  cloud.points[1].y() = kNan;
  cloud.points[3].z() = -kInf;
  for (const char* name : {"a.ply", "a.pcd", "a.xyz"}) {
    WriteCloud(Path(name), cloud);
    ExpectSame(ReadCloud(Path(name)), expected);
  }
  for (auto& point : cloud.points) point.setConstant(kNan);
  WriteCloud(Path("a.ply"), cloud);
  EXPECT_THAT(ErrorOf(Path("a.ply")), HasSubstr("holds no points"));
}

TEST_F(CloudIo, MapPlyIsReadBack) {
  const Eigen::Vector3d offset(393000.125, 5707000.0, 0.1);
  MapPlyWriter writer(Path("map.ply"), offset);
  const Cloud cloud = RandomCloud(140000, true);
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    writer.Add(cloud.points[i], cloud.colors[i], PointSource::kVision, static_cast<std::int32_t>(i),
               -1);
  }
  EXPECT_EQ(writer.count(), 140000u);
  EXPECT_FALSE(std::filesystem::exists(Path("map.ply")));
  writer.Commit();
  const Cloud read = ReadCloud(Path("map.ply"));
  EXPECT_EQ(read.offset, offset);
  EXPECT_EQ(read.points, cloud.points);
  EXPECT_EQ(read.colors, cloud.colors);
  const std::string text = ReadTextFile(Path("map.ply"));
  EXPECT_THAT(text.substr(0, 400), HasSubstr("\nelement vertex 140000\nproperty float x\n"));
  EXPECT_EQ(text.substr(text.size() - 9),
            std::string(1, '\1') + Bytes<std::int32_t>(139999) + Bytes<std::int32_t>(-1));
}

TEST_F(CloudIo, MapPlyIsReadBackBySources) {
  const Eigen::Vector3d offset(393000.125, 5707000.0, 0.1);
  const Cloud cloud = RandomCloud(40000, true);  // several blocks
  std::vector<std::uint32_t> laser, vision;
  {
    MapPlyWriter writer(Path("map.ply"), offset);
    for (std::uint32_t i = 0; i < cloud.size(); ++i) {
      const bool is_vision = i % 3 == 1;
      (is_vision ? vision : laser).push_back(i);
      writer.Add(cloud.points[i], cloud.colors[i],
                 is_vision ? PointSource::kVision : PointSource::kLaser, 0, 0);
      if (i == 7) writer.Add({NAN, 0, 0}, {1, 2, 3}, PointSource::kVision, 0, 0);
    }
    writer.Commit();
  }
  const MergedMap map = ReadMapPly(Path("map.ply"));
  EXPECT_EQ(map.laser.points, Select(cloud, laser).points);
  EXPECT_EQ(map.vision.points, Select(cloud, vision).points);
  EXPECT_EQ(map.vision.colors, Select(cloud, vision).colors);
  EXPECT_EQ(map.laser.offset, offset);
  EXPECT_EQ(map.vision.offset, offset);
}

TEST_F(CloudIo, OfTooManyPointsOfASourceEverySecondOneStays) {
  const Cloud cloud = RandomCloud(1000, true);
  {
    MapPlyWriter writer(Path("map.ply"), Eigen::Vector3d::Zero());
    for (std::size_t i = 0; i < cloud.size(); ++i) {
      writer.Add(cloud.points[i], cloud.colors[i], PointSource::kVision, -1, 0);
      writer.Add(cloud.points[i], cloud.colors[i], PointSource::kLaser, 0, 0);
    }
    writer.Commit();
  }
  for (const std::size_t most : {1, 2, 30, 999, 1000, 5000}) {
    const MergedMap map = ReadMapPly(Path("map.ply"), most);
    ASSERT_LE(map.vision.size(), most);
    EXPECT_GT(2 * map.vision.size(), std::min(most, cloud.size()) - 1);
    std::uint32_t step = 1;
    while (cloud.size() > most * step) step *= 2;
    std::vector<std::uint32_t> kept;
    for (std::uint32_t i = 0; i < cloud.size(); i += step) kept.push_back(i);
    EXPECT_EQ(map.laser.points, Select(cloud, kept).points) << most;
    EXPECT_EQ(map.vision.points, Select(cloud, kept).points) << most;
    EXPECT_EQ(map.vision.colors, Select(cloud, kept).colors) << most;
  }
}

TEST_F(CloudIo, ADamagedMapPlyIsNamed) {
  {
    MapPlyWriter writer(Path("map.ply"), Eigen::Vector3d::Zero());
    for (int i = 0; i < 5; ++i) writer.Add({1, 2, 3}, {1, 2, 3}, PointSource::kVision, -1, 0);
    writer.Commit();
  }
  const std::string whole = ReadTextFile(Path("map.ply"));
  for (std::size_t size = 0; size < whole.size(); size += 7) {
    EXPECT_THROW(ReadMapPly(Write("cut.ply", whole.substr(0, size))), InputError) << size;
  }
  std::string many = whole;
  many.replace(many.find("element vertex 5"), 16, "element vertex 5000000000000");
  EXPECT_THROW(ReadMapPly(Write("many.ply", many)), InputError);
  EXPECT_THROW(ReadMapPly(Path("absent.ply")), InputError);
}

TEST_F(CloudIo, PointsOfAnyOtherPlyAreTheLasers) {
  const Cloud cloud = RandomCloud(10, true);
  WriteCloud(Path("a.ply"), cloud);
  EXPECT_EQ(ReadMapPly(Path("a.ply")).laser.points, cloud.points);
  EXPECT_EQ(ReadMapPly(Path("a.ply")).vision.size(), 0u);
}

TEST_F(CloudIo, UncommittedMapLeavesNothing) {
  {
    MapPlyWriter writer(Path("map.ply"), Eigen::Vector3d::Zero());
    writer.Add({1, 2, 3}, {1, 2, 3}, PointSource::kLaser, 0, 0);
  }
  EXPECT_TRUE(std::filesystem::is_empty(Path("")));
}

TEST_F(CloudIo, FormatIsCheckedAgainstTheContent) {
  Cloud cloud;
  cloud.points = {{1, 2, 3}};
  WriteCloud(Path("a.ply"), cloud);
  std::filesystem::copy(Path("a.ply"), Path("a.pcd"));
  std::filesystem::copy(Path("a.ply"), Path("a.cloud"));
  EXPECT_THAT(ErrorOf(Path("a.pcd")), HasSubstr("holds ply, not pcd"));
  EXPECT_THAT(ErrorOf(Path("a.ply"), "xyz"), HasSubstr("holds ply, not xyz"));
  EXPECT_EQ(ReadCloud(Path("a.cloud")).size(), 1u);
  EXPECT_EQ(ReadCloud(Path("a.pcd"), "ply").size(), 1u);
  EXPECT_THROW(ReadCloud(Path("a.ply"), "las"), UsageError);
  EXPECT_THAT(ErrorOf(Write("b.cloud", "1 2 3\n")), HasSubstr("no known cloud format"));
  EXPECT_EQ(ReadCloud(Path("b.cloud"), "xyz").size(), 1u);
  EXPECT_THAT(ErrorOf(Write("text.pcd", "hello\n")), HasSubstr("not a PCD header"));
  EXPECT_THAT(ErrorOf(Write("empty.ply", "")), HasSubstr("is empty"));
  EXPECT_THAT(ErrorOf(Path("none.ply")), HasSubstr("cannot be read"));
  EXPECT_THAT(ErrorOf(Path("")), HasSubstr("folder"));
}

}  // namespace
}  // namespace planegraph
