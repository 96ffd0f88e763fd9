#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "io/cloud_formats.h"
#include "io/test_files.h"

namespace planegraph {
namespace {

using testing::HasSubstr;
using Color = std::array<std::uint8_t, 3>;

std::string TextErrorOf(const std::string& text, bool is_3dtk = false) {
  return ErrorOf([&] { (is_3dtk ? Parse3dtkCloud : ParseXyz)(text, "f.txt"); });
}

TEST(Xyz, EverySeparatorWithAndWithoutHeader) {
  for (const char* text : {"1 2 3\n4 5 6\n", "1,2,3\n4,5,6", "1;2;3\r\n4;5;6\r\n",
                           "1\t2\t3\n4\t5\t6\n", " 1 , 2 , 3 \n\n4,5 ,6\n", "x y z\n1 2 3\n4 5 6\n",
                           "X,Y,Z\n1,2,3\n4,5,6\n", "\"x\";\"y\";\"z\"\n1;2;3\n4;5;6\n",
                           "//X Y Z\n1 2 3\n4 5 6\n", "# a comment\n1 2 3\n#\n4 5 6\n",
                           "2\n1 2 3\n4 5 6\n", "z,name,y,x\n3,first one,2,1\n6,,5,4\n"}) {
    const Cloud cloud = ParseXyz(text, "f");
    ASSERT_EQ(cloud.size(), 2u) << text;
    EXPECT_EQ(cloud.points[0], Eigen::Vector3f(1, 2, 3)) << text;
    EXPECT_EQ(cloud.points[1], Eigen::Vector3f(4, 5, 6)) << text;
  }
}

TEST(Xyz, NamedColumns) {
  const Cloud cloud = ParseXyz("b,g,r,Intensity,x,y,z,nx,ny,nz\n3,2,1,0.5,10,20,30,0,1,0\n", "f");
  EXPECT_EQ(cloud.points[0], Eigen::Vector3f(10, 20, 30));
  EXPECT_EQ(cloud.colors[0], (Color{1, 2, 3}));
  EXPECT_EQ(cloud.normals[0], Eigen::Vector3f(0, 1, 0));
  EXPECT_EQ(cloud.intensities[0], 0.5f);
}

TEST(Xyz, UnnamedColumnsGoByTheirNumber) {
  EXPECT_EQ(ParseXyz("1 2 3 0.25\n", "f").intensities, std::vector<float>{0.25f});
  EXPECT_EQ(ParseXyz("1 2 3 10 20 30\n", "f").colors[0], (Color{10, 20, 30}));
  EXPECT_EQ(ParseXyz("1 2 3 0.6 0 -0.8\n", "f").normals[0], Eigen::Vector3f(0.6f, 0, -0.8f));
  const Cloud pts = ParseXyz("1\n1 2 3 -700 10 20 30\n", "f");
  EXPECT_EQ(pts.colors[0], (Color{10, 20, 30}));
  EXPECT_EQ(pts.intensities[0], -700.0f);
  EXPECT_TRUE(ParseXyz("1 2 3 4 5\n", "f").intensities.empty());
}

TEST(Xyz, LargeCoordinatesKeepAnOffset) {
  const Cloud cloud = ParseXyz("393123.456789 5707456.123456 112.5\n393124 5707457 113\n", "f");
  EXPECT_EQ(cloud.offset, Eigen::Vector3d(393123, 5707456, 113));
  EXPECT_LE((cloud.Position(0) - Eigen::Vector3d(393123.456789, 5707456.123456, 112.5)).norm(),
            1e-7);
  EXPECT_EQ(cloud.Position(1), Eigen::Vector3d(393124, 5707457, 113));
  EXPECT_EQ(ParseXyz("9999 0 0\n", "f").offset, Eigen::Vector3d::Zero());
}

// A cloud on both sides of the 10 km from which on it needs an offset.
TEST(TextClouds, PointsBeforeTheOneThatGivesTheOffsetKeepTheirDigits) {
  const std::string lines = "9990.0004 1 2\n10010.25 3 4\n";
  const std::string ply =
      "ply\nformat ascii 1.0\nelement vertex 2\nproperty double x\nproperty double y\nproperty "
      "double z\nend_header\n";
  const std::string pcd =
      "FIELDS x y z\nSIZE 8 8 8\nTYPE F F F\nWIDTH 2\nHEIGHT 1\nPOINTS 2\nDATA ascii\n";
  for (const Cloud& cloud :
       {ParsePly(ply + lines, "f"), ParsePcd(pcd + lines, "f"), ParseXyz(lines, "f"),
        Parse3dtkCloud("-100 200 999000.04\n-300 400 1001025\n", "f")}) {
    ASSERT_EQ(cloud.size(), 2u);
    EXPECT_EQ(cloud.offset.x(), 10010.0);
    EXPECT_NEAR(cloud.Position(0).x(), 9990.0004, 2e-6);
    EXPECT_NEAR(cloud.Position(1).x(), 10010.25, 2e-6);
  }
}

TEST(Xyz, NonFiniteRowsAreDropped) {
  const Cloud cloud = ParseXyz("nan 1 2\n1 2 3\n1 inf 3\n1e999 0 0\n1e-999 0 0\n", "f");
  ASSERT_EQ(cloud.size(), 2u);
  EXPECT_EQ(cloud.points[1], Eigen::Vector3f(0, 0, 0));
}

// Found by fuzzing: a finite number that no float holds, and one that would spoil the offset.
TEST(Xyz, AbsurdNumbersDoNotSpoilTheRest) {
  const Cloud cloud = ParseXyz("1 2 3\n5e51 0 0\n1e20 0 0\n393123 5707456 113\n", "f");
  ASSERT_EQ(cloud.size(), 3u);
  EXPECT_EQ(cloud.offset, Eigen::Vector3d(393123, 5707456, 113));
  for (const auto& point : cloud.points) EXPECT_TRUE(point.allFinite());
  EXPECT_EQ(cloud.points[2], Eigen::Vector3f(0, 0, 0));
}

TEST(Xyz, BadLinesAreNamed) {
  EXPECT_THAT(TextErrorOf("hello world\n"), HasSubstr("f.txt:1:"));
  EXPECT_THAT(TextErrorOf("1 2 3\n4 5\n"), HasSubstr("f.txt:2: column 3 is missing"));
  EXPECT_THAT(TextErrorOf("1 2 3\n4 five 6\n"), HasSubstr("f.txt:2: column 2 is not a number"));
  EXPECT_THAT(TextErrorOf("1,2,3\n4,,6\n"), HasSubstr("f.txt:2: column 2"));
  EXPECT_THAT(TextErrorOf("1 2 3\n1 2 3x\n"), HasSubstr("f.txt:2: column 3"));
  EXPECT_THAT(TextErrorOf("a,b,c\n1,2,3\n"), HasSubstr("names of columns"));
  EXPECT_THAT(TextErrorOf("1 2\n"), HasSubstr("f.txt:1: column 3"));
  EXPECT_EQ(ParseXyz("", "f").size(), 0u);
  EXPECT_EQ(ParseXyz("# nothing\n", "f").size(), 0u);
}

// x right, y up, z forward in cm become x forward, y left, z up in m.
TEST(Cloud3dtk, IsTurnedAndScaled) {
  const Cloud cloud = Parse3dtkCloud("1000 x 500\nscan\n100 200 300\n-50 0 25 \n", "f");
  ASSERT_EQ(cloud.size(), 2u);
  EXPECT_EQ(cloud.points[0], Eigen::Vector3f(3, -1, 2));
  EXPECT_EQ(cloud.points[1], Eigen::Vector3f(0.25f, 0.5f, 0));
  EXPECT_EQ(Parse3dtkCloud("100 200 300 9\n", "f").intensities[0], 9.0f);
}

TEST(Cloud3dtk, TenHeaderLinesAtMost) {
  std::string header;
  for (int i = 0; i < 10; ++i) header += "words\n";
  EXPECT_EQ(Parse3dtkCloud(header + "1 2 3\n", "f").size(), 1u);
  EXPECT_THAT(TextErrorOf(header + "words\n1 2 3\n", true), HasSubstr("f.txt:11:"));
  EXPECT_THAT(TextErrorOf("1 2 3\nwords\n", true), HasSubstr("f.txt:2:"));
}

}  // namespace
}  // namespace planegraph
