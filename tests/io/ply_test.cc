#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "io/cloud_formats.h"
#include "io/test_files.h"

namespace planegraph {
namespace {

using testing::HasSubstr;

const char kXyz[] = "property float x\nproperty float y\nproperty float z\n";

std::string PlyHeaderText(const std::string& format, const std::string& elements) {
  return "ply\nformat " + format + " 1.0\n" + elements + "end_header\n";
}

std::string PlyErrorOf(const std::string& bytes) {
  return ErrorOf([&] { ParsePly(bytes, "f.ply"); });
}

TEST(Ply, AsciiWithColourNormalsAndUnknownColumns) {
  const Cloud cloud = ParsePly(
      PlyHeaderText(
          "ascii",
          "comment made by hand\nobj_info x\nelement vertex 2\nproperty float confidence\n"
          "property double z\nproperty float32 y\nproperty float x\nproperty uchar red\n"
          "property uint8 green\nproperty uchar blue\nproperty float nx\nproperty float ny\n"
          "property float nz\nproperty float scalar_Intensity\n") +
          "0.5 3 2 1 10 20 30 0 0 1 7.5\r\n\n9 6e0 +5 -4 255 0 1 1 0 0 8\n",
      "f");
  ASSERT_EQ(cloud.size(), 2u);
  EXPECT_EQ(cloud.points[0], Eigen::Vector3f(1, 2, 3));
  EXPECT_EQ(cloud.points[1], Eigen::Vector3f(-4, 5, 6));
  EXPECT_EQ(cloud.colors[1], (std::array<std::uint8_t, 3>{255, 0, 1}));
  EXPECT_EQ(cloud.normals[0], Eigen::Vector3f(0, 0, 1));
  EXPECT_EQ(cloud.intensities[1], 8.0f);
}

TEST(Ply, BothByteOrdersAndAllTypes) {
  for (const bool big : {false, true}) {
    const std::string format = big ? "binary_big_endian" : "binary_little_endian";
    const std::string floats = PlyHeaderText(format, std::string("element vertex 2\n") + kXyz);
    const Cloud a = ParsePly(floats + Triple(1.f, 2.f, 3.f, big) + Triple(4.f, 5.f, 6.f, big), "f");
    EXPECT_EQ(a.points[1], Eigen::Vector3f(4, 5, 6));
    const std::string mixed = PlyHeaderText(
        format,
        "element vertex 1\nproperty short x\nproperty int y\nproperty double z\nproperty uchar "
        "skip\nproperty float red\nproperty float green\nproperty float blue\n"
        "property ushort intensity\n");
    const Cloud b = ParsePly(mixed + Bytes<std::int16_t>(-7, big) + Bytes<std::int32_t>(9, big) +
                                 Bytes(0.5, big) + "s" + Triple(1.f, 0.f, 0.5f, big) +
                                 Bytes<std::uint16_t>(300, big),
                             "f");
    EXPECT_EQ(b.points[0], Eigen::Vector3f(-7, 9, 0.5));
    EXPECT_EQ(b.colors[0], (std::array<std::uint8_t, 3>{255, 0, 128}));
    EXPECT_EQ(b.intensities[0], 300.0f);
  }
}

TEST(Ply, LargeDoublesKeepAnOffset) {
  const std::string header =
      PlyHeaderText("binary_little_endian",
                    "element vertex 3\nproperty double x\nproperty double y\nproperty double z\n");
  // A dummy at zero comes first: the offset must not be taken from it.
  const Cloud cloud =
      ParsePly(header + Triple(0.0, 0.0, 0.0) + Triple(393123.456789, 5707456.123456, 112.5) +
                   Triple(393125.0, 5707450.0, 110.0),
               "f");
  EXPECT_EQ(cloud.offset, Eigen::Vector3d(393123, 5707456, 113));
  EXPECT_LE((cloud.Position(1) - Eigen::Vector3d(393123.456789, 5707456.123456, 112.5)).norm(),
            1e-7);
  EXPECT_EQ(cloud.Position(2), Eigen::Vector3d(393125.0, 5707450.0, 110.0));
  EXPECT_LE(cloud.Position(0).norm(), 1.0);
  const Cloud text = ParsePly(PlyHeaderText("ascii", std::string("element vertex 2\n") + kXyz) +
                                  "0 0 0\n393123.456789 5707456.123456 112.5\n",
                              "f");
  EXPECT_LE((text.Position(1) - cloud.Position(1)).norm(), 1e-7);
  EXPECT_LE(text.Position(0).norm(), 1.0);
}

TEST(Ply, StatedOffsetIsAdded) {
  const Cloud cloud = ParsePly(
      PlyHeaderText("ascii",
                    std::string("comment offset 1e6 2000000.5 -3\nelement vertex 1\n") + kXyz) +
          "1 2 3\n",
      "f");
  EXPECT_EQ(cloud.offset, Eigen::Vector3d(1e6, 2000000.5, -3));
  EXPECT_EQ(cloud.Position(0), Eigen::Vector3d(1000001, 2000002.5, 0));
  EXPECT_THAT(PlyErrorOf(PlyHeaderText("ascii", "comment offset 1 2\n")), HasSubstr("f.ply:3:"));
  EXPECT_THAT(PlyErrorOf(PlyHeaderText("ascii", "comment offset 1 2 inf\n")),
              HasSubstr("three numbers"));
}

TEST(Ply, FacesBeforeAndAfterTheVertices) {
  const std::string face = "element face 2\nproperty list uchar int vertex_indices\n";
  const std::string vertex = std::string("element vertex 2\n") + kXyz;
  const std::string faces =
      Bytes<char>(3) + Triple<std::int32_t>(0, 1, 0) + Bytes<char>(1) + Bytes<std::int32_t>(1);
  const std::string points = Triple(1.f, 2.f, 3.f) + Triple(4.f, 5.f, 6.f);
  const std::string binary = "binary_little_endian";
  for (const std::string& bytes :
       {PlyHeaderText(binary, face + vertex) + faces + points,
        PlyHeaderText(binary, vertex + face) + points + faces,
        PlyHeaderText("ascii", face + vertex) + "3 0 1 0\n1 1\n1 2 3\n4 5 6\n",
        PlyHeaderText("ascii", vertex + face) + "1 2 3\n4 5 6\n3 0 1 0\n1 1\n"}) {
    const Cloud cloud = ParsePly(bytes, "f");
    ASSERT_EQ(cloud.size(), 2u);
    EXPECT_EQ(cloud.points[0], Eigen::Vector3f(1, 2, 3));
    EXPECT_EQ(cloud.points[1], Eigen::Vector3f(4, 5, 6));
  }
}

TEST(Ply, ListsInsideVerticesAreSkipped) {
  const std::string vertex =
      "element vertex 2\nproperty float x\nproperty list ushort double w\nproperty float y\n"
      "property float z\n";
  for (const bool big : {false, true}) {
    const auto list = [&](std::uint16_t n) {
      std::string bytes = Bytes(n, big);
      for (int i = 0; i < n; ++i) bytes += Bytes(1e9, big);
      return bytes;
    };
    const std::string body = Bytes(1.f, big) + list(3) + Bytes(2.f, big) + Bytes(3.f, big) +
                             Bytes(4.f, big) + list(0) + Bytes(5.f, big) + Bytes(6.f, big);
    const std::string header =
        PlyHeaderText(big ? "binary_big_endian" : "binary_little_endian", vertex);
    const Cloud cloud = ParsePly(header + body, "f");
    EXPECT_EQ(cloud.points[0], Eigen::Vector3f(1, 2, 3));
    EXPECT_EQ(cloud.points[1], Eigen::Vector3f(4, 5, 6));
    EXPECT_THAT(PlyErrorOf(header + body.substr(0, body.size() - 1)), HasSubstr("1 bytes"));
  }
  const Cloud cloud = ParsePly(PlyHeaderText("ascii", vertex) + "1 2 9 9 2 3\n4 0 5 6\n", "f");
  EXPECT_EQ(cloud.points[0], Eigen::Vector3f(1, 2, 3));
  EXPECT_EQ(cloud.points[1], Eigen::Vector3f(4, 5, 6));
  EXPECT_THAT(PlyErrorOf(PlyHeaderText("ascii", vertex) + "1 9 9 9 2 3\n4 0 5 6\n"),
              HasSubstr("list"));
}

TEST(Ply, TruncationSaysHowMuchIsMissing) {
  const std::string whole =
      PlyHeaderText("binary_little_endian", std::string("element vertex 2\n") + kXyz) +
      Triple(1.f, 2.f, 3.f) + Triple(4.f, 5.f, 6.f);
  EXPECT_THAT(PlyErrorOf(whole.substr(0, whole.size() - 5)), HasSubstr("ends 5 bytes before"));
  EXPECT_THAT(PlyErrorOf(whole.substr(0, whole.size() - 24)), HasSubstr("ends 24 bytes before"));
}

TEST(Ply, BadFilesAreInputErrorsAtOnce) {
  const std::string binary = "binary_little_endian", xyz = kXyz;
  const struct {
    std::string bytes, expected;
  } cases[] = {
      {"plyx\n", "f.ply:1:"},
      {"ply\n", "end_header"},
      {"ply\nend_header\n", "no format"},
      {"ply\nformat binary_middle_endian 1.0\n", "f.ply:2:"},
      {PlyHeaderText("ascii", "elephant vertex 3\n"), "f.ply:3: unknown header line"},
      {PlyHeaderText("ascii", "property float x\n"), "before any element"},
      {PlyHeaderText("ascii", "element vertex -5\n" + xyz), "negative"},
      {PlyHeaderText("ascii", "element vertex 5.5\n" + xyz), "f.ply:3:"},
      {PlyHeaderText("ascii", "element vertex 99999999999999999999\n" + xyz), "f.ply:3:"},
      {PlyHeaderText("ascii", "element vertex 1\nproperty quad x\n"), "unknown type"},
      {PlyHeaderText("ascii", "element vertex 1\nproperty list float int x\n"), "integer"},
      {PlyHeaderText("ascii", "element face 1\n"), "no element 'vertex'"},
      {PlyHeaderText("ascii", "element vertex 1\nproperty float x\nproperty float y\n"),
       "no x, y, z"},
      {PlyHeaderText("ascii", "element vertex 16000000000\n" + xyz) + "1 2 3\n",
       "16000000000 points"},
      {PlyHeaderText("ascii", "element vertex 2\n" + xyz) + "1 2 3            \n", "1 of 2"},
      {PlyHeaderText("ascii", "element vertex 2\n" + xyz) + "1 2 3\n1 two 3\n",
       "f.ply:9: column 2"},
      {PlyHeaderText("ascii", "element vertex 1\n" + xyz) + "1 2        \n", "column 3 is missing"},
      {PlyHeaderText(binary, "element vertex 16000000000\n" + xyz), "192000000000 bytes"},
      {PlyHeaderText(binary, "element vertex 9000000000000000000\n" + xyz), "more than 1e19 bytes"},
      {PlyHeaderText(
           binary, "element face 4000000000\nproperty list uchar int i\nelement vertex 1\n" + xyz),
       "4000000000 bytes"},
      {PlyHeaderText(binary, "element face 1\nproperty list int int i\nelement vertex 1\n" + xyz) +
           Bytes<std::int32_t>(-1) + std::string(40, '\0'),
       "bytes before its data"}};
  for (const auto& c : cases) EXPECT_THAT(PlyErrorOf(c.bytes), HasSubstr(c.expected)) << c.bytes;
}

}  // namespace
}  // namespace planegraph
