#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <functional>

#include "io/camera_formats.h"
#include "io/test_files.h"
#include "planegraph/io/camera_io.h"

namespace planegraph {
namespace {

using testing::HasSubstr;

class ColmapIo : public TestFolder {};

const std::string kColmapCameras = "# comment\n1 PINHOLE 640 480 501 502 320 240\n";
const std::string kColmapImages =
    "# comment\n2 0.70710678118654752 0 0 0.70710678118654752 1 2 3 1 b c.jpg\n"
    "1.5 2.5 -1 3.5 4.5 7\n1 1 0 0 0 0 0 0 9 a.jpg\n\n";
const std::string kColmapPoints = "# comment\n7 1 2 3 10 20 30 0.5 1 2 2 3\n";

template <typename... Values>
std::string Pack(Values... values) {
  return (Bytes(values) + ...);
}
using U32 = std::uint32_t;
using U64 = std::uint64_t;
const double kHalf = 0.70710678118654752;

std::string BinaryCameras() {
  return Pack(U64(1), U32(1), std::int32_t(1), U64(640), U64(480), 501.0, 502.0, 320.0, 240.0);
}
std::string BinaryImages() {
  std::string bytes =
      Pack(U64(2), U32(2), kHalf, 0.0, 0.0, kHalf, 1.0, 2.0, 3.0, U32(1)) + "b c.jpg";
  bytes += '\0' + Pack(U64(2), 1.5, 2.5, U64(-1), 3.5, 4.5, U64(7));
  bytes += Pack(U32(1), 1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, U32(9)) + "a.jpg";
  return bytes + '\0' + Pack(U64(0));
}
std::string BinaryPoints() {
  return Pack(U64(1), U64(7), 1.0, 2.0, 3.0) + "\x0a\x14\x1e" +
         Pack(0.5, U64(2), U32(1), U32(2), U32(2), U32(3));
}

void ExpectColmap(const CameraModel& model) {
  EXPECT_EQ(model.format, "colmap");
  ASSERT_EQ(model.cameras.size(), 2u);
  EXPECT_EQ(model.cameras[0].image, "b c.jpg");
  EXPECT_EQ(model.cameras[0].focal, 501.0);
  EXPECT_LT((model.cameras[0].Centre() - Eigen::Vector3d(-2, 1, -3)).norm(), 1e-12);
  EXPECT_EQ(model.cameras[1].image, "a.jpg");
  EXPECT_EQ(model.cameras[1].focal, 0.0);
  EXPECT_TRUE(model.cameras[1].valid);
  ASSERT_EQ(model.points.size(), 1u);
  EXPECT_EQ(model.points[0], Eigen::Vector3d(1, 2, 3));
}

TEST_F(ColmapIo, ColmapTextAndBinary) {
  Write("t/cameras.txt", kColmapCameras);
  Write("t/images.txt", kColmapImages);
  Write("t/points3D.txt", kColmapPoints);
  Write("b/cameras.bin", BinaryCameras());
  Write("b/images.bin", BinaryImages());
  Write("b/points3D.bin", BinaryPoints());
  for (const char* path : {"t", "t/images.txt", "t/cameras.txt", "b", "b/images.bin"}) {
    SCOPED_TRACE(path);
    ExpectColmap(ReadCameras(Path(path)));
  }
}

TEST_F(ColmapIo, ColmapImagesAlone) {
  Write("images.txt", kColmapImages);
  const CameraModel model = ReadCameras(Path("images.txt"));
  EXPECT_EQ(model.cameras.size(), 2u);
  EXPECT_TRUE(model.points.empty());
  std::filesystem::remove(Path("images.txt"));
  Write("cameras.txt", kColmapCameras);
  EXPECT_THAT(ErrorOf([&] { ReadCameras(Path("")); }), HasSubstr("without images.bin"));
}

TEST_F(ColmapIo, DamagedColmapTextIsNamed) {
  const auto images = [](const std::string& text) {
    return ErrorOf([&] { ParseColmapImages(text, {}, "f"); });
  };
  EXPECT_THAT(images("1 1 0 0 0 0 0 0 9\n"), HasSubstr("f:1: the image has no name"));
  EXPECT_THAT(images("1 1 0 0 0 0 0\n"), HasSubstr("f:1: the line has too few words"));
  EXPECT_THAT(images("\n1 2 0 0 0 0 0 0 9 a\n"), HasSubstr("f:2: the quaternion"));
  EXPECT_THAT(images("1 nan 0 0 0 0 0 0 9 a\n"), HasSubstr("f:1: is not a finite number"));
  EXPECT_THAT(images("1 1 0 0 0 inf 0 0 9 a\n"), HasSubstr("f:1: is not a finite number"));
  EXPECT_THAT(images("x 1 0 0 0 0 0 0 9 a\n"), HasSubstr("f:1: is no id"));
  EXPECT_THAT(images("1 1 0 0 0 0 0 0 9 a\n2 1 0 0 0 0 0 0 9 b\n"),
              HasSubstr("f:2: is no line of key points"));
  EXPECT_THAT(ErrorOf([] { ParseColmapCameras("1 PINHOLE 640 480 -5\n", "f"); }),
              HasSubstr("f:1: the focal length"));
  EXPECT_THAT(ErrorOf([] { ParseColmapPoints("1 2 3\n", "f"); }), HasSubstr("f:1: the line has"));
}

TEST_F(ColmapIo, DamagedColmapBinaryIsNamed) {
  const auto images = [](const std::string& bytes) {
    return ErrorOf([&] { ParseColmapImagesBinary(bytes, {}, "f"); });
  };
  const std::string whole = BinaryImages();
  for (std::size_t length = 0; length < whole.size(); ++length) {
    EXPECT_THAT(images(whole.substr(0, length)), HasSubstr("f:byte ")) << length;
  }
  EXPECT_THAT(images(Pack(U64(1) << 60) + whole.substr(8)), HasSubstr("but only"));
  EXPECT_THAT(images(Pack(U64(1), U32(2), std::nan("")) + whole.substr(20)), HasSubstr("finite"));
  const auto cameras = [](const std::string& bytes) {
    return ErrorOf([&] { ParseColmapCamerasBinary(bytes, "f"); });
  };
  for (std::size_t length = 0; length < BinaryCameras().size(); ++length) {
    EXPECT_THAT(cameras(BinaryCameras().substr(0, length)), HasSubstr("f:byte ")) << length;
  }
  EXPECT_THAT(cameras(Pack(U64(1), U32(1), std::int32_t(77)) + BinaryCameras().substr(16)),
              HasSubstr("unknown camera model 77"));
  for (std::size_t length = 0; length < BinaryPoints().size(); ++length) {
    EXPECT_THAT(ErrorOf([&] { ParseColmapPointsBinary(BinaryPoints().substr(0, length), "f"); }),
                HasSubstr("f:byte "))
        << length;
  }
}

}  // namespace
}  // namespace planegraph
