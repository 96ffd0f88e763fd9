#include "planegraph/io/camera_io.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <functional>
#include <random>

#include "io/camera_formats.h"
#include "io/test_files.h"
#include "planegraph/geometry/rotation.h"
#include "planegraph/io/cloud_io.h"

namespace planegraph {
namespace {

using testing::HasSubstr;

class CameraIo : public TestFolder {
 protected:
  std::string ReadError(const std::string& path) const {
    return ErrorOf([&] { ReadCameras(path); });
  }
};

// A quarter turn about z: x_camera = (-y, x, z) + (1, 2, 3).
const std::string kTurned = "0 -1 0\n1 0 0\n0 0 1\n1 2 3\n";
const std::string kPoint = "7 8 9\n1 2 3\n";

TEST_F(CameraIo, Mve) {
  const auto path = Write("synth_0.out", "drews 1.0\n2 2\n0.72 0.1 0\n" + kTurned +
                                             "0 0 0\n0 0 0\n0 0 0\n0 0 0\n0 0 0\n" + kPoint +
                                             "2 0 5 0 1 6 0\n4 5 6\n1 2 3\n0\n");
  const CameraModel model = ReadCameras(path);
  EXPECT_EQ(model.format, "mve");
  ASSERT_EQ(model.cameras.size(), 2u);
  EXPECT_TRUE(model.cameras[0].valid);
  EXPECT_EQ(model.cameras[0].focal, 0.72);
  EXPECT_FALSE(model.cameras[1].valid);
  // -R^T t with R^T (x, y, z) = (y, -x, z).
  EXPECT_LT((model.cameras[0].Centre() - Eigen::Vector3d(-2, 1, -3)).norm(), 1e-12);
  EXPECT_LT(
      (model.cameras[0].camera_from_model * Eigen::Vector3d(1, 0, 0) - Eigen::Vector3d(1, 3, 3))
          .norm(),
      1e-12);
  ASSERT_EQ(model.points.size(), 2u);
  EXPECT_EQ(model.points[1], Eigen::Vector3d(4, 5, 6));
}

TEST_F(CameraIo, BundlerIsTurnedAndNamed) {
  const std::string bundle =
      "# Bundle file v0.3\n1 1\n500 0 0\n" + kTurned + kPoint + "1 0 5 -3.5 2.5\n";
  Write("list.txt", "images/a.jpg 0 500\n");
  const CameraModel model = ReadCameras(Write("bundle.out", bundle));
  EXPECT_EQ(model.format, "bundler");
  EXPECT_EQ(model.cameras[0].image, "images/a.jpg");
  // The centre is that of the file; y and z of the camera's frame turn their signs.
  EXPECT_LT((model.cameras[0].Centre() - Eigen::Vector3d(-2, 1, -3)).norm(), 1e-12);
  EXPECT_LT(
      (model.cameras[0].camera_from_model * Eigen::Vector3d(1, 0, 0) - Eigen::Vector3d(1, -3, -3))
          .norm(),
      1e-12);
  Write("list.txt", "a.jpg\nb.jpg\n");
  EXPECT_EQ(ReadCameras(Path("bundle.out")).cameras[0].image, "");
}

TEST_F(CameraIo, MveComesBack) {
  std::mt19937 rng(1);
  std::normal_distribution<double> normal;
  const auto draw = [&] { return normal(rng); };
  CameraModel model;
  for (int k = 0; k < 20; ++k) {
    Camera camera;
    camera.valid = k % 5 != 2;
    camera.focal = camera.valid ? 0.5 + k : 0.0;
    camera.camera_from_model = {ExpSO3(Eigen::Vector3d::NullaryExpr(draw)),
                                1e3 * Eigen::Vector3d::NullaryExpr(draw)};
    model.cameras.push_back(camera);
    model.points.push_back(Eigen::Vector3d::NullaryExpr(draw));
  }
  WriteMveCameras(Path("a.out"), model);
  const CameraModel read = ReadCameras(Path("a.out"));
  ASSERT_EQ(read.cameras.size(), 20u);
  for (std::size_t k = 0; k < 20; ++k) {
    EXPECT_EQ(read.cameras[k].valid, model.cameras[k].valid);
    EXPECT_EQ(read.cameras[k].focal, model.cameras[k].focal);
    EXPECT_EQ(read.points[k], model.points[k]);
    if (!read.cameras[k].valid) continue;
    EXPECT_EQ(read.cameras[k].camera_from_model.translation,
              model.cameras[k].camera_from_model.translation);
    EXPECT_LT(AngleBetween(read.cameras[k].camera_from_model.rotation,
                           model.cameras[k].camera_from_model.rotation),
              1e-14);
  }
}

TEST_F(CameraIo, DamagedBundlesAreNamed) {
  const std::string mve = "drews 1.0\n";
  const std::string whole = mve + "1 1\n1 0 0\n" + kTurned + kPoint + "1 0 0 0\n";
  EXPECT_EQ(ErrorOf([&] { ParseBundle(whole, "f"); }), "(no error)");
  const struct {
    std::string text, expected;
  } cases[] = {
      {"", "f:1: holds no cameras in a known format"},
      {"drews 2.0\n", "f:1: holds no cameras"},
      {"# Bundle file v0.2\n", "f:1: is a Bundler file, but not"},
      {mve, "f:2: the file ends"},
      {mve + "-1 0\n", "f:2: is no number of cameras"},
      {mve + "1e3 0\n", "f:2: is no number of cameras"},
      {mve + "1000000000000 0\n", "f:2: 1000000000000 cameras, but"},
      {mve + "1 999999999\n1 0 0\n" + kTurned, "f:2: 999999999 points, but"},
      {mve + "1 0\n1 0 0\n0 -1 0\n1 0 0\n0 0 1\n1 2\n", "the file ends too early"},
      {mve + "1 0\n1 0 0\n0 -1 0\n1 nan 0\n0 0 1\n1 2 3\n", "f:5: is not a finite number: 'nan'"},
      {mve + "1 0\n-1 0 0\n" + kTurned, "f:3: the focal length is negative"},
      {mve + "1 0\n1 0 0\n0 -1 0\n2 0 0\n0 0 1\n1 2 3\n", "f:4: the 3x3 matrix is not a rotation"},
      {mve + "1 1\n1 0 0\n" + kTurned + kPoint + "99999 0 0 0\n", "99999 views, but"}};
  for (const auto& c : cases) {
    EXPECT_THAT(ErrorOf([&] { ParseBundle(c.text, "f"); }), HasSubstr(c.expected)) << c.text;
  }
  for (std::size_t length = 0; length + 3 < whole.size(); ++length) {
    EXPECT_NE(ErrorOf([&] { ParseBundle(whole.substr(0, length), "f"); }), "(no error)") << length;
  }
  EXPECT_THAT(ReadError(Path("none.out")), HasSubstr("none.out"));
  EXPECT_THAT(ReadError(Write("e.out", mve + "0 0\n")), HasSubstr("holds no camera"));
}

// ---- OpenSfM ----

const std::string kShot = R"({"rotation": [0, 0, 1.5707963267948966], "translation": [1, 2, 3],
  "camera": "c"})";
const std::string kReconstruction =
    R"([{"cameras": {"c": {"focal": 0.85}}, "shots": {"z.jpg": )" + kShot +
    R"(, "a.jpg": {"rotation": [0, 0, 0], "translation": [0, 0, 0]}},
  "points": {"1": {"coordinates": [1, 2, 3], "color": [0, 0, 0]}}}, {"shots": {"q.jpg": {}}}])";

TEST_F(CameraIo, OpenSfmKeepsTheOrder) {
  const CameraModel model = ReadCameras(Write("reconstruction.json", kReconstruction));
  EXPECT_EQ(model.format, "opensfm");
  EXPECT_EQ(model.ignored_models, 1u);
  ASSERT_EQ(model.cameras.size(), 2u);
  EXPECT_EQ(model.cameras[0].image, "z.jpg");
  EXPECT_EQ(model.cameras[0].focal, 0.85);
  EXPECT_LT((model.cameras[0].Centre() - Eigen::Vector3d(-2, 1, -3)).norm(), 1e-12);
  EXPECT_EQ(model.cameras[1].image, "a.jpg");
  ASSERT_EQ(model.points.size(), 1u);
  EXPECT_EQ(model.points[0], Eigen::Vector3d(1, 2, 3));
}

TEST_F(CameraIo, DamagedOpenSfmIsNamed) {
  const auto parse = [](const std::string& text) {
    return ErrorOf([&] { ParseOpenSfm(text, "f"); });
  };
  EXPECT_THAT(parse("[{"), HasSubstr("f:byte "));
  EXPECT_THAT(parse("[]"), HasSubstr("is no OpenSfM"));
  EXPECT_THAT(parse("[3]"), HasSubstr("is no OpenSfM"));
  EXPECT_THAT(parse(R"([{"shots": []}])"), HasSubstr("is no OpenSfM"));
  EXPECT_THAT(parse(R"([{"shots": {"a": 3}}])"), HasSubstr("a has no `rotation`"));
  EXPECT_THAT(parse(R"([{"shots": {"a": {"rotation": [1, 2], "translation": [1, 2, 3]}}}])"),
              HasSubstr("`rotation` of a is not three finite numbers"));
  EXPECT_THAT(parse(R"([{"shots": {"a": {"rotation": [1, 2, "3"], "translation": [1, 2, 3]}}}])"),
              HasSubstr("`rotation` of a"));
  EXPECT_THAT(parse(R"([{"shots": {"a": {"rotation": [1, 2, 1e999]}}}])"), HasSubstr("range"));
  EXPECT_THAT(ReadError(Write("r.json", R"([{"shots": {}}])")), HasSubstr("holds no camera"));
}

// ---- files of others ----

TEST_F(CameraIo, SharedModels) {
  const std::string base = PLANEGRAPH_SHARED_DATA;
  if (!std::filesystem::exists(base + "/hybrid-site-a/uav")) GTEST_SKIP() << "no " << base;
  const CameraModel mve = ReadCameras(base + "/hybrid-site-a/uav/mve/synth_0.out");
  ASSERT_EQ(mve.cameras.size(), 139u);
  EXPECT_EQ(std::count_if(mve.cameras.begin(), mve.cameras.end(),
                          [](const Camera& c) { return c.valid; }),
            134);
  EXPECT_EQ(mve.points.size(), 19396u);
  const CameraModel beach = ReadCameras(base + "/photogrammetry/brighton_beach/colmap");
  EXPECT_EQ(beach.cameras.size(), 18u);
  EXPECT_EQ(beach.points.size(), 2672u);
  EXPECT_NEAR(beach.cameras[0].focal, 816.2608, 1e-3);
}

// Clouds of the same programs have columns that are none of ours.
TEST_F(CameraIo, CloudsOfMveAndColmap) {
  const std::string mve =
      "ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nproperty float y\n"
      "property float z\nproperty float nx\nproperty float ny\nproperty float nz\n"
      "property uchar red\nproperty uchar green\nproperty uchar blue\n";
  const std::string extra = "property float confidence\nproperty float value\n";
  const Cloud fused = ReadCloud(Write("fused.ply", mve + "end_header\n1 2 3 0 0 1 10 20 30\n"));
  const Cloud pset =
      ReadCloud(Write("pset.ply", mve + extra + "end_header\n1 2 3 0 0 1 10 20 30 0.5 0.01\n"));
  for (const Cloud* cloud : {&fused, &pset}) {
    ASSERT_EQ(cloud->size(), 1u);
    EXPECT_EQ(cloud->normals[0], Eigen::Vector3f(0, 0, 1));
    EXPECT_EQ(cloud->colors[0][2], 30);
    EXPECT_TRUE(cloud->intensities.empty());
  }
  const std::string shared =
      std::string(PLANEGRAPH_SHARED_DATA) + "/hybrid-site-a/uav/mve/cloud.ply";
  if (!std::filesystem::exists(shared)) GTEST_SKIP() << "no " << shared;
  const Cloud cloud = ReadCloud(shared);
  EXPECT_EQ(cloud.size(), 660000u);
  EXPECT_EQ(cloud.normals.size(), cloud.size());
  EXPECT_EQ(cloud.colors.size(), cloud.size());
  EXPECT_NEAR(cloud.normals[1000].norm(), 1.0, 1e-3);
}

}  // namespace
}  // namespace planegraph
