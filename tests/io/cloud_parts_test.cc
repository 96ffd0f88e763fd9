#include "planegraph/io/cloud_parts.h"

#include <fstream>
#include <random>

#include "io/test_files.h"
#include "planegraph/base/atomic_file.h"
#include "planegraph/io/cloud_io.h"

namespace planegraph {
namespace {

class CloudPartsTest : public TestFolder {
 protected:
  // Points with all attributes; `far`: metres from the origin.
  static Cloud Random(std::size_t count, double far = 0.0) {
    std::mt19937_64 engine(7);
    std::uniform_real_distribution<float> uniform(-50.0f, 50.0f);
    Cloud cloud;
    cloud.offset = Eigen::Vector3d(far, -far, 0.0);
    for (std::size_t i = 0; i < count; ++i) {
      cloud.points.emplace_back(uniform(engine), uniform(engine), uniform(engine));
      cloud.normals.push_back(Eigen::Vector3f(uniform(engine), 1.0f, 2.0f).normalized());
      cloud.colors.push_back({static_cast<std::uint8_t>(i), static_cast<std::uint8_t>(i / 256), 9});
    }
    return cloud;
  }

  static Cloud Gather(CloudParts* parts) {
    Cloud all, part;
    while (parts->Next(&part)) {
      all.offset = part.offset;
      all.viewpoint = part.viewpoint;
      all.points.insert(all.points.end(), part.points.begin(), part.points.end());
      all.normals.insert(all.normals.end(), part.normals.begin(), part.normals.end());
      all.colors.insert(all.colors.end(), part.colors.begin(), part.colors.end());
    }
    return all;
  }

  static void ExpectSame(const Cloud& found, const Cloud& expected) {
    EXPECT_EQ(found.offset, expected.offset);
    EXPECT_EQ(found.viewpoint, expected.viewpoint);
    EXPECT_EQ(found.points, expected.points);
    EXPECT_EQ(found.normals, expected.normals);
    EXPECT_EQ(found.colors, expected.colors);
  }

  // Text of a PLY or PCD with positions as they are written; ascii.
  static std::string AsciiPly(const Cloud& cloud) {
    std::string text = "ply\nformat ascii 1.0\nelement vertex " + std::to_string(cloud.size()) +
                       "\nproperty double x\nproperty double y\nproperty double z\nproperty uchar "
                       "red\nproperty uchar green\nproperty uchar blue\nend_header\n";
    return text + Lines(cloud);
  }
  static std::string AsciiPcd(const Cloud& cloud) {
    std::string text =
        "VERSION 0.7\nFIELDS x y z r g b\nSIZE 8 8 8 1 1 1\nTYPE F F F U U U\nCOUNT 1 1 1 1 1 "
        "1\nWIDTH " +
        std::to_string(cloud.size()) + "\nHEIGHT 1\nVIEWPOINT 1 2 3 1 0 0 0\nPOINTS " +
        std::to_string(cloud.size()) + "\nDATA ascii\n";
    return text + Lines(cloud);
  }
  static std::string Lines(const Cloud& cloud) {
    std::string text;
    char line[128];
    for (std::size_t i = 0; i < cloud.size(); ++i) {
      const Eigen::Vector3d p = cloud.Position(i);
      const auto& c = cloud.colors[i];
      std::snprintf(line, sizeof(line), "%.6f %.6f %.6f %d %d %d\n%s", p.x(), p.y(), p.z(), c[0],
                    c[1], c[2], i % 7 == 0 ? "\r\n" : "");
      text += line;
    }
    return text;
  }
};

TEST_F(CloudPartsTest, PartsAreTheWholeWhateverTheirSize) {
  const Cloud cloud = Random(1000), far = Random(1000, 4.0e5);
  WriteCloud(Path("a.ply"), cloud);
  WriteCloud(Path("b.pcd"), cloud);
  WriteCloud(Path("c.ply"), far);
  Write("d.ply", AsciiPly(cloud));
  Write("e.ply", AsciiPly(far));
  Write("f.pcd", AsciiPcd(far));
  for (const char* name : {"a.ply", "b.pcd", "c.ply", "d.ply", "e.ply", "f.pcd"}) {
    ASSERT_TRUE(CloudParts::CanRead(Path(name))) << name;
    const Cloud whole = ReadCloud(Path(name));
    for (const std::size_t most : {1, 7, 999, 1000, 5000}) {
      CloudParts parts(Path(name), most);
      EXPECT_EQ(parts.promised(), 1000u);
      ExpectSame(Gather(&parts), whole);
      parts.Rewind();
      ExpectSame(Gather(&parts), whole);
    }
  }
}

TEST_F(CloudPartsTest, OnePartHoldsNoMoreThanItMay) {
  WriteCloud(Path("a.ply"), Random(1000));
  CloudParts parts(Path("a.ply"), 300);
  Cloud part;
  std::size_t calls = 0;
  for (; parts.Next(&part); ++calls) EXPECT_LE(part.size(), 300u);
  EXPECT_EQ(calls, 4u);
}

TEST_F(CloudPartsTest, LargeDoublesThatComeLateGiveAllPartsOneOffset) {
  std::string body;
  for (int i = 0; i < 100; ++i) {
    const double far = i < 60 ? 0.0 : 5.0e5;
    for (const double value : {far + i, far, 3.0}) body += Bytes(value);
  }
  const std::string header =
      "ply\nformat binary_little_endian 1.0\nelement vertex 100\nproperty double x\nproperty "
      "double y\nproperty double z\nend_header\n";
  const std::string path = Write("late.ply", header + body);
  CloudParts parts(path, 10);
  ExpectSame(Gather(&parts), ReadCloud(path));
}

TEST_F(CloudPartsTest, PointsThatAreNotFiniteAreDropped) {
  Cloud cloud = Random(100);
  cloud.points[3].x() = NAN;
  cloud.points[99].z() = INFINITY;
  WriteCloud(Path("a.ply"), cloud);
  CloudParts parts(Path("a.ply"), 10);
  const Cloud found = Gather(&parts);
  EXPECT_EQ(found.size(), 98u);
  ExpectSame(found, ReadCloud(Path("a.ply")));
}

TEST_F(CloudPartsTest, CutFilesAreInputErrorsWhereverTheyEnd) {
  WriteCloud(Path("a.ply"), Random(50));
  WriteCloud(Path("b.pcd"), Random(50));
  Write("c.ply", AsciiPly(Random(50)));
  for (const char* name : {"a.ply", "b.pcd", "c.ply"}) {
    const std::string bytes = ReadTextFile(Path(name));
    for (std::size_t length = 40; length + 45 < bytes.size(); length += 37) {
      const std::string path = Write(std::string("cut_") + name, bytes.substr(0, length));
      EXPECT_THROW(
          {
            CloudParts parts(path, 8);
            Gather(&parts);
          },
          InputError)
          << name << " " << length;
    }
  }
}

TEST_F(CloudPartsTest, CountsThatTheFileHasNoRoomForAreInputErrors) {
  const std::string tail =
      "\nproperty float x\nproperty float y\nproperty float z\nend_header\n" + std::string(12, 'a');
  for (const char* count : {"3", "1000000000000", "18446744073709551615"}) {
    for (const char* format : {"binary_little_endian", "ascii"}) {
      const std::string path = Write(
          "a.ply", std::string("ply\nformat ") + format + " 1.0\nelement vertex " + count + tail);
      EXPECT_THROW(CloudParts::CanRead(path), InputError) << count << " " << format;
    }
  }
}

TEST_F(CloudPartsTest, SaysWhatItCannotRead) {
  const std::string lists = Write(
      "lists.ply",
      "ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nproperty float y\nproperty float "
      "z\nproperty list uchar int views\nend_header\n1 2 3 2 0 1\n");
  EXPECT_FALSE(CloudParts::CanRead(lists));
  EXPECT_FALSE(CloudParts::CanRead(Write("a.xyz", "1 2 3\n4 5 6\n")));
  EXPECT_THROW(CloudParts{lists}, std::invalid_argument);
}

}  // namespace
}  // namespace planegraph
