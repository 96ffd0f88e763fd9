#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <bit>

#include "io/cloud_formats.h"
#include "io/cloud_layout.h"
#include "io/lzf.h"
#include "io/test_files.h"

namespace planegraph {
namespace {

using testing::HasSubstr;

struct Fields {
  std::string names = "x y z", sizes = "4 4 4", types = "F F F", counts = "1 1 1";
};

std::string PcdHeaderText(const std::string& points, const std::string& data,
                          const Fields& fields = {}) {
  return "# .PCD v0.7\nVERSION 0.7\nFIELDS " + fields.names + "\nSIZE " + fields.sizes + "\nTYPE " +
         fields.types + "\nCOUNT " + fields.counts + "\nWIDTH " + points +
         "\nHEIGHT 1\nVIEWPOINT 1 2 3 1 0 0 0\nPOINTS " + points + "\nDATA " + data + "\n";
}

std::string PcdErrorOf(const std::string& bytes) {
  return ErrorOf([&] { ParsePcd(bytes, "f.pcd"); });
}

// A valid LZF stream without any repetition.
std::string PackLiterals(const std::string& data) {
  std::string packed;
  for (std::size_t at = 0; at < data.size(); at += 32) {
    const std::string part = data.substr(at, 32);
    packed += static_cast<char>(part.size() - 1) + part;
  }
  return packed;
}

std::string Compressed(const std::string& packed, std::size_t unpacked) {
  return Bytes(static_cast<std::uint32_t>(packed.size())) +
         Bytes(static_cast<std::uint32_t>(unpacked)) + packed;
}

const Fields kRich = {"x y z rgb normal_x normal_y normal_z intensity ring", "4 4 4 4 4 4 4 4 2",
                      "F F F F F F F F U", "1 1 1 1 1 1 1 1 2"};
constexpr std::uint32_t kColor = 0x00102030;

TEST(Pcd, AsciiWithEverything) {
  // PCL prints the float whose bits are the colour.
  const std::string rgb = "1.48157e-39";
  const Cloud cloud = ParsePcd(PcdHeaderText("2", "ascii", kRich) + "1 2 3 " + rgb +
                                   " 0 0 1 7 4 5\nnan nan nan 0 0 0 0 0 4 5\n",
                               "f");
  ASSERT_EQ(cloud.size(), 1u);
  EXPECT_EQ(cloud.points[0], Eigen::Vector3f(1, 2, 3));
  EXPECT_EQ(cloud.normals[0], Eigen::Vector3f(0, 0, 1));
  EXPECT_EQ(cloud.intensities[0], 7.0f);
  EXPECT_EQ(cloud.viewpoint, Eigen::Vector3d(1, 2, 3));
  EXPECT_EQ(cloud.colors[0][0], 0x10);
  const Fields integer = {"x y z rgb", "4 4 4 4", "F F F U", "1 1 1 1"};
  const Cloud exact = ParsePcd(PcdHeaderText("1", "ascii", integer) + "1 2 3 4278190335\n", "f");
  EXPECT_EQ(exact.colors[0], (std::array<std::uint8_t, 3>{0, 0, 255}));
}

TEST(Pcd, BinaryAndCompressedHoldTheSame) {
  const std::string rgb = Bytes(kColor), ring = Bytes<std::uint16_t>(3) + Bytes<std::uint16_t>(4);
  const std::string by_point = Triple(1.f, 2.f, 3.f) + rgb + Triple(0.f, 0.f, 1.f) + Bytes(7.f) +
                               ring + Triple(4.f, 5.f, 6.f) + rgb + Triple(1.f, 0.f, 0.f) +
                               Bytes(8.f) + ring;
  std::string by_field;
  for (const float v : {1.f, 4.f, 2.f, 5.f, 3.f, 6.f}) by_field += Bytes(v);
  by_field += rgb + rgb;
  for (const float v : {0.f, 1.f, 0.f, 0.f, 1.f, 0.f, 7.f, 8.f}) by_field += Bytes(v);
  by_field += ring + ring;
  const std::string body = Compressed(PackLiterals(by_field), by_field.size());
  for (const std::string& bytes : {PcdHeaderText("2", "binary", kRich) + by_point,
                                   PcdHeaderText("2", "binary_compressed", kRich) + body}) {
    const Cloud cloud = ParsePcd(bytes, "f");
    ASSERT_EQ(cloud.size(), 2u);
    EXPECT_EQ(cloud.points[1], Eigen::Vector3f(4, 5, 6));
    EXPECT_EQ(cloud.normals[1], Eigen::Vector3f(1, 0, 0));
    EXPECT_EQ(cloud.colors[1], (std::array<std::uint8_t, 3>{0x10, 0x20, 0x30}));
    EXPECT_EQ(cloud.intensities, (std::vector<float>{7, 8}));
    EXPECT_EQ(cloud.viewpoint, Eigen::Vector3d(1, 2, 3));
    EXPECT_THAT(PcdErrorOf(bytes.substr(0, bytes.size() - 3)), HasSubstr("3 bytes"));
  }
}

TEST(Pcd, LargeDoublesKeepAnOffset) {
  const Fields fields = {"x y z", "8 8 8", "F F F", "1 1 1"};
  const Eigen::Vector3d p(393123.456789, 5707456.123456, 112.5);
  const Cloud cloud =
      ParsePcd(PcdHeaderText("1", "binary", fields) + Triple(p.x(), p.y(), p.z()), "f");
  EXPECT_EQ(cloud.offset, Eigen::Vector3d(393123, 5707456, 113));
  EXPECT_LE((cloud.Position(0) - p).norm(), 1e-7);
}

// liblzf's own packing of "aaaa...": a literal, then one long reference to it (distance 1,
// overlap).
TEST(Lzf, ReferencesMayOverlap) {
  const std::string packed(
      "\x00"
      "a"
      "\xe0\x04\x00",
      5);
  const auto data = UnpackLzf(packed, 14, "f", 0);
  EXPECT_EQ(std::string(data.begin(), data.end()), std::string(14, 'a'));
  const std::string two(
      "\x02"
      "abc"
      "\x20\x02",
      6);
  const auto repeated = UnpackLzf(two, 6, "f", 0);
  EXPECT_EQ(std::string(repeated.begin(), repeated.end()), "abcabc");
}

TEST(Lzf, StaysInItsBounds) {
  const struct {
    std::string packed;
    std::size_t size;
  } cases[] = {{std::string("\x05"
                            "ab",
                            3),
                6},                              // literal runs out
               {std::string("\x00", 1), 1},      // no literal byte
               {std::string("\x20\x00", 2), 3},  // refers to before the start
               {std::string("\x00"
                            "a\xe0",
                            3),
                300},  // length byte missing
               {std::string("\x00"
                            "a\x20",
                            3),
                4},  // distance byte missing
               {std::string("\x00"
                            "a\xe0\xff\x00",
                            5),
                10},  // longer than promised
               {std::string("\x00"
                            "a",
                            2),
                2},  // shorter than promised
               {std::string("\x01"
                            "ab",
                            3),
                1}};
  for (const auto& c : cases) EXPECT_THROW(UnpackLzf(c.packed, c.size, "f", 0), InputError);
}

TEST(Pcd, FieldsOfSeveralValuesTakeAsManyColumns) {
  const Fields fields = {"ring x none y z", "2 4 4 4 4", "U F F F F", "3 1 0 1 1"};
  const Cloud cloud = ParsePcd(PcdHeaderText("1", "ascii", fields) + "7 ? 9 1 2 3\n", "f.pcd");
  ASSERT_EQ(cloud.size(), 1u);
  EXPECT_EQ(cloud.points[0], Eigen::Vector3f(1, 2, 3));
  EXPECT_THAT(PcdErrorOf(PcdHeaderText("1", "ascii", fields) + "7 8 9 10 11 \n"),
              HasSubstr("column 6 is missing"));
  EXPECT_THAT(PcdErrorOf(PcdHeaderText("1", "ascii", fields) + "7 8 9 1 x 3\n"),
              HasSubstr("column 5 is not a number"));
}

// A few kilobytes that promise columns by the thousand million.
TEST(Pcd, CountsTakeNoMemory) {
  Fields fields;
  for (int i = 0; i < 3000; ++i) {
    fields.names += " f", fields.sizes += " 4", fields.types += " F", fields.counts += " 1000000";
  }
  const std::string bytes = PcdHeaderText("1", "ascii", fields) + "1 2 3\n";
  const PcdHeader header = ParsePcdHeader(bytes, "f.pcd");
  EXPECT_EQ(header.PointValues(), 3000000003u);
  EXPECT_EQ(TextColumnsOf(header, RolesOf(header, "f.pcd")).roles.size(), 3003u);
  EXPECT_THAT(PcdErrorOf(bytes), HasSubstr("promises 1 points"));
}

TEST(Pcd, BadFilesAreInputErrorsAtOnce) {
  const std::string body = Triple(1.f, 2.f, 3.f);
  const Fields double_types = {"x y z", "4 4 4", "F F", "1 1 1"};
  const Fields odd = {"x y z", "4 4 3", "F F F", "1 1 1"};
  const Fields huge_count = {"x y z h", "4 4 4 8", "F F F F", "1 1 1 9999999999"};
  const Fields no_z = {"x y", "4 4", "F F", "1 1"};
  const struct {
    std::string bytes, expected;
  } cases[] = {
      {"hello\n", "f.pcd:1:"},
      {"# .PCD v0.7\n", "no DATA"},
      {"DATA ascii\n", "no FIELDS"},
      {PcdHeaderText("1", "zip"), "f.pcd:11: DATA must be"},
      {PcdHeaderText("-5", "ascii"), "f.pcd:7: WIDTH is negative"},
      {PcdHeaderText("x", "ascii"), "f.pcd:7:"},
      {PcdHeaderText("16000000000", "binary"), "192000000000 bytes"},
      {PcdHeaderText("4000000000000000000", "binary"), "more than 1e19 bytes"},
      {PcdHeaderText("9000000000000000000", "ascii"), "f.pcd:7: WIDTH * HEIGHT"},
      {PcdHeaderText("1000", "ascii") + "1 2 3\n", "promises 1000 points"},
      {PcdHeaderText("2", "ascii") + "1 2 3             \n", "1 of 2 points"},
      {PcdHeaderText("1", "ascii") + "1 2 z             \n", "f.pcd:12: column 3"},
      {PcdHeaderText("1", "binary", double_types) + body, "f.pcd:5:"},
      {PcdHeaderText("1", "binary", odd) + body, "unknown field type"},
      {PcdHeaderText("1", "binary", huge_count) + body, "f.pcd:6:"},
      {PcdHeaderText("1", "binary", no_z) + body, "no x, y, z"},
      {PcdHeaderText("1", "binary_compressed") + "abc", "5 bytes"},
      {PcdHeaderText("1", "binary_compressed") + Compressed("abc", 13), "unpacked size"},
      {PcdHeaderText("300000000", "binary_compressed") + Compressed("abc", 3600000000),
       "too short"},
      {PcdHeaderText("1", "binary_compressed") + Compressed("abc", 12), "compressed data"}};
  for (const auto& c : cases) EXPECT_THAT(PcdErrorOf(c.bytes), HasSubstr(c.expected)) << c.bytes;
  std::string mismatch = PcdHeaderText("1", "binary") + body;
  mismatch.replace(mismatch.find("POINTS 1"), 8, "POINTS 2");
  EXPECT_THAT(PcdErrorOf(mismatch), HasSubstr("POINTS is not"));
}

}  // namespace
}  // namespace planegraph
