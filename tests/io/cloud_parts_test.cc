#include "planegraph/io/cloud_parts.h"

#include <fstream>
#include <functional>
#include <map>
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

  // Of the parts and the whole.
  static void ExpectSameError(const std::string& path, std::size_t trace) {
    const std::string whole = ErrorOf([&] { ReadCloud(path); });
    EXPECT_NE(whole, "none") << path << " " << trace;
    EXPECT_EQ(ErrorOf([&] {
                CloudParts parts(path, 8);
                Gather(&parts);
              }),
              whole)
        << trace;
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
      EXPECT_EQ(parts.extent().points, 1000u);
      ExpectSame(Gather(&parts), whole);
      parts.Rewind();
      ExpectSame(Gather(&parts), whole);
    }
  }
}

TEST_F(CloudPartsTest, LinesAreTheSameWhateverTheBlocksOfText) {
  const Cloud far = Random(60, 4.0e5);
  Write("a.ply", AsciiPly(far));
  Write("b.pcd", AsciiPcd(far));
  const std::string without_feed = AsciiPly(far);
  Write("c.ply", without_feed.substr(0, without_feed.find_last_not_of("\r\n") + 1));
  for (const char* name : {"a.ply", "b.pcd", "c.ply"}) {
    const Cloud whole = ReadCloud(Path(name));
    ASSERT_EQ(whole.size(), 60u);
    for (std::size_t block = 1; block <= 64; ++block) {
      CloudParts parts(Path(name), 7, CloudParts::Offset::kAtOnce, block);
      ExpectSame(Gather(&parts), whole);
    }
  }
}

// Numbers that are none would end any reading of the points.
TEST_F(CloudPartsTest, TheExtentIsReadFromTheHeaderAlone) {
  std::string text = AsciiPly(Random(100));
  text.replace(text.find("end_header\n") + 11, 8, "rubbish!");
  const std::string path = Write("a.ply", text);
  const auto extent = CloudParts::Measure(path);
  ASSERT_TRUE(extent);
  EXPECT_EQ(extent->points, 100u);
  EXPECT_EQ(extent->bytes, text.size());
  EXPECT_THROW(CloudParts{path}, InputError);
}

TEST_F(CloudPartsTest, AnOffsetThatComesOnTheWayIsThereFromTheSecondWayOn) {
  const Cloud near = Random(30), far = Random(30, 4.0e5);
  std::string late = AsciiPly(near);
  late.replace(late.find("vertex 30"), 9, "vertex 60");
  Write("late.ply", late + Lines(far));
  Write("far.ply", AsciiPly(far));
  Write("near.ply", AsciiPly(near));
  for (const char* name : {"late.ply", "far.ply", "near.ply"}) {
    const Cloud whole = ReadCloud(Path(name));
    CloudParts at_once(Path(name), 7), parts(Path(name), 7, CloudParts::Offset::kOnTheWay);
    const Cloud first = Gather(&parts);
    EXPECT_EQ(first.size(), whole.size());
    EXPECT_EQ(parts.OffsetCameLate(), name == std::string("late.ply"));
    parts.Rewind();
    EXPECT_FALSE(parts.OffsetCameLate());
    ExpectSame(Gather(&parts), Gather(&at_once));
    EXPECT_FALSE(parts.OffsetCameLate());
  }
}

TEST_F(CloudPartsTest, ALineWithoutAnEndIsNotKept) {
  std::string text = AsciiPly(Random(10));
  for (const char* start : {"", "1 2 3 4 5 6\n"}) {
    const std::string path = Write("a.ply", text.substr(0, text.find("end_header\n") + 11) + start +
                                                std::string(5000000, ' '));
    try {
      CloudParts parts(path, 8);
      Gather(&parts);
      FAIL() << start;
    } catch (const InputError& error) {
      EXPECT_EQ(error.place(), *start ? "12" : "11");
      EXPECT_NE(error.reason().find("longer"), std::string::npos) << error.reason();
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

TEST_F(CloudPartsTest, CutFilesAreTheInputErrorsOfTheWholeFile) {
  WriteCloud(Path("a.ply"), Random(50));
  WriteCloud(Path("b.pcd"), Random(50));
  Write("c.ply", AsciiPly(Random(50)));
  Write("d.pcd", AsciiPcd(Random(50)));
  for (const char* name : {"a.ply", "b.pcd", "c.ply", "d.pcd"}) {
    const std::string bytes = ReadTextFile(Path(name));
    for (std::size_t length = 1; length + 45 < bytes.size(); length += 19) {
      const std::string path = Write(std::string("cut_") + name, bytes.substr(0, length));
      ExpectSameError(path, length);
    }
  }
}

TEST_F(CloudPartsTest, LinesThatAreNoPointsAreTheInputErrorsOfTheWholeFile) {
  const std::string ply = AsciiPly(Random(50)), pcd = AsciiPcd(Random(50));
  for (const char* wrong : {"1 2", "1 2 x 4 5 6", "1 2 3 4 5 six", "-"}) {
    for (const std::string* text : {&ply, &pcd}) {
      std::string changed = *text;
      const std::size_t line = changed.find('\n', changed.size() / 2) + 1;
      changed.replace(line, changed.find('\n', line) - line, wrong);
      ExpectSameError(Write(text == &ply ? "a.ply" : "a.pcd", changed), line);
    }
  }
}

TEST_F(CloudPartsTest, FilesOfEveryKindAreReadAsTheWhole) {
  const std::string xyz = "property float x\nproperty float y\nproperty float z\n";
  const std::string vertex = "element vertex 3\n" + xyz, end = "end_header\n";
  const std::string ascii = "ply\nformat ascii 1.0\n", lines = "1 2 3\n4 5 6\n7 8 9\n";
  const std::string pcd =
      "VERSION 0.7\nFIELDS ring x y z rgb\nSIZE 2 4 4 4 4\nTYPE U F F F U\nCOUNT 2 1 1 1 1\nWIDTH "
      "3\nHEIGHT 1\nPOINTS 3\nDATA ";
  std::string floats, swapped, records;
  for (int i = 0; i < 9; ++i) {
    floats += Bytes(1.5f * i), swapped += Bytes(1.5 * i, true);
    if (i % 3 == 0) records += Bytes(std::uint32_t{77});
    records += Bytes(0.5f * i);
    if (i % 3 == 2) records += Bytes(std::uint32_t{0x102030u + i});
  }
  const std::map<std::string, std::string> files = {
      {"before.ply", "ply\nformat binary_little_endian 1.0\nelement camera 2\nproperty double f\n" +
                         vertex + end + std::string(16, 'c') + floats},
      {"nothing_before.ply", ascii + "element empty 7\n" + vertex + end + lines},
      {"big.ply",
       "ply\nformat binary_big_endian 1.0\nelement vertex 3\nproperty double "
       "x\nproperty double y\nproperty double z\n" +
           end + swapped},
      {"offset.ply",
       ascii + "comment offset 4e5 5e6 7\ncomment viewpoint 1 2 3\n" + vertex + end + lines},
      {"large_with_offset.ply",
       ascii + "comment offset 4e5 5e6 7\n" + vertex + end + "1 2 3\n4e5 5 6\n7 8 9\n"},
      {"not_finite.ply", ascii + vertex + end + "1 2 3\nnan 5 6\n7 inf 9\n"},
      {"far.ply", ascii + vertex + end + "1 2 3\n4 5 1e31\n7 8e5 9\n"},
      {"both_sides.ply",
       "ply\nformat ascii 1.0\nelement vertex 3\nproperty double x\nproperty "
       "double y\nproperty double z\n" +
           end + "9990.0004 1 2\n-9990.0004 5 6\n10010.25 3 4\n"},
      {"packed.pcd", pcd + "ascii\n1 2 3 4 5 70000\n1 2 nan 4 5 70000\n3 4 5 6 7 80000\n"},
      {"packed_binary.pcd", pcd + "binary\n" + records},
      {"comment.pcd", "# mine\n" + pcd + "binary\n" + records},
      {"fields.pcd", pcd.substr(pcd.find("FIELDS")) + "binary\n" + records},
      {"no_ending", ascii + vertex + end + lines}};
  for (const auto& [name, bytes] : files) {
    const std::string path = Write(name, bytes);
    const Cloud whole = ReadCloud(path);
    for (const std::size_t most : {1, 2, 3}) {
      CloudParts parts(path, most);
      EXPECT_EQ(parts.extent().points, 3u) << name;
      SCOPED_TRACE(name);
      ExpectSame(Gather(&parts), whole);
    }
  }
}

TEST_F(CloudPartsTest, NoPointsAreNoParts) {
  for (const char* format : {"ascii", "binary_little_endian"}) {
    const std::string path =
        Write("a.ply", std::string("ply\nformat ") + format +
                           " 1.0\nelement vertex 0\nproperty double x\nproperty double y\nproperty "
                           "double z\nend_header\n");
    CloudParts parts(path);
    Cloud part;
    EXPECT_EQ(parts.extent().points, 0u);
    EXPECT_FALSE(parts.Next(&part));
  }
}

// What is not in parts is read as a whole.
TEST_F(CloudPartsTest, LongHeadersAreLeftToTheReaderOfTheWhole) {
  const std::string ply = AsciiPly(Random(10)), pcd = AsciiPcd(Random(10));
  const std::string comments(1100000, 'c');
  const std::string long_ply =
      Write("a.ply", "ply\ncomment " + comments + "\n" + ply.substr(ply.find("format")));
  const std::string long_pcd = Write("a.pcd", "# .PCD " + comments + "\n" + pcd);
  for (const std::string& path : {long_ply, long_pcd}) {
    EXPECT_FALSE(CloudParts::CanRead(path)) << path;
    EXPECT_EQ(ReadCloud(path).size(), 10u);
  }
}

TEST_F(CloudPartsTest, TheEndingCountsAsItDoesForTheWhole) {
  const std::string path = Write("a.xyz", AsciiPly(Random(10)));
  EXPECT_THROW(CloudParts::CanRead(path), InputError);
  ExpectSameError(path, 0);
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
