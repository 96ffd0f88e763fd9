#include "planegraph/registration/georeference.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>

#include "planegraph/base/error.h"
#include "registration/flight_world.h"

namespace planegraph {
namespace {

using testing::HasSubstr;

TEST(Georeference, ExactDataGiveTheExactSimilarity) {
  const FlightWorld world;
  for (const char* method : {"robust", "paper"}) {
    GeoreferenceOptions options = world.Options();
    options.method = method;
    const Georeference result = Locate(world, world.Track(world.NoNoise()), options);
    EXPECT_EQ(result.status, "ok") << result.reason;
    EXPECT_LT(world.ErrorOf(result.world_from_map).norm(), 1e-6);
    EXPECT_LT(result.rms, 1e-6);
    EXPECT_EQ(result.inliers.size(), 120u);
    EXPECT_EQ(result.time_offset, 0.0);
    EXPECT_EQ(result.origin->latitude, world.origin.latitude);
  }
}

TEST(Georeference, MetricPositionsByImageHaveNoOrigin) {
  const FlightWorld world;
  const Georeference result = ComputeGeoreference(world.Model(), world.MetricTrack(world.NoNoise()),
                                                  std::nullopt, world.Options());
  EXPECT_EQ(result.status, "ok");
  EXPECT_FALSE(result.origin.has_value());
  EXPECT_LT(world.ErrorOf(result.world_from_map).norm(), 1e-9);
}

TEST(Georeference, TheFirstFixIsTheOriginUnlessOneIsGiven) {
  const FlightWorld world;
  const GpsTrack track = world.Track(world.NoNoise());
  GeoreferenceOptions options = world.Options();
  options.origin.reset();
  const Georeference result = Locate(world, track, options);
  EXPECT_EQ(result.origin->latitude, track.fixes[0].geodetic->latitude);
  EXPECT_LT((result.world_from_map * world.Model().cameras[0].Centre()).norm(), 1e-6);
}

TEST(Georeference, UnregisteredCamerasAreSkipped) {
  const FlightWorld world;
  CameraModel model = world.Model();
  for (const std::size_t k : {3u, 50u}) model.cameras[k] = Camera();
  const Georeference result =
      ComputeGeoreference(model, world.Track(world.NoNoise()), world.Times(), world.Options());
  EXPECT_EQ(result.inliers.size(), 118u);
  EXPECT_EQ(std::count(result.inliers.begin(), result.inliers.end(), 50u), 0);
  EXPECT_LT(world.ErrorOf(result.world_from_map).norm(), 1e-6);
}

TEST(Georeference, TheOrderOfCamerasAndFixesDoesNotMatter) {
  const FlightWorld world;
  std::mt19937_64 rng(9);
  const GpsTrack track = world.Track(world.Noise(&rng, {1, 1, 2}));
  CameraModel model = world.Model();
  ImageTimes times = world.Times();
  GpsTrack turned = track;
  const Georeference before = ComputeGeoreference(model, track, times, world.Options());
  std::reverse(model.cameras.begin(), model.cameras.end());
  std::reverse(times.times.begin(), times.times.end());
  std::reverse(times.files.begin(), times.files.end());
  std::reverse(turned.fixes.begin(), turned.fixes.end());
  const Georeference after = ComputeGeoreference(model, turned, times, world.Options());
  EXPECT_EQ(before.world_from_map.scale, after.world_from_map.scale);
  EXPECT_EQ(before.world_from_map.translation, after.world_from_map.translation);
  EXPECT_EQ(before.covariance, after.covariance);
}

TEST(Georeference, NamedCamerasFindTheirTimesInAnyOrder) {
  const FlightWorld world;
  ImageTimes times = world.Times();
  std::reverse(times.times.begin(), times.times.end());
  std::reverse(times.files.begin(), times.files.end());
  const Georeference result =
      ComputeGeoreference(world.Model(), world.Track(world.NoNoise()), times, world.Options());
  EXPECT_LT(result.rms, 1e-6);
}

TEST(Georeference, WholeDaysBetweenTheClocks) {
  const FlightWorld world;
  GpsTrack track = world.Track(world.NoNoise());
  for (GpsFix& fix : track.fixes) fix.time += 19000 * 86400.0;
  const Georeference result = Locate(world, track, world.Options());
  EXPECT_EQ(result.status, "ok") << result.reason;
  EXPECT_EQ(result.time_offset, 19000 * 86400.0);
}

TEST(Georeference, ImagesMeetByTheirNamesInSeveralForms) {
  const FlightWorld world;
  const GpsTrack track = world.MetricTrack(world.NoNoise());
  for (const std::string folder : {"", "left/", "C:\\flight\\"}) {
    CameraModel model = world.Model();
    for (Camera& camera : model.cameras) camera.image = folder + camera.image;
    const Georeference result = ComputeGeoreference(model, track, std::nullopt);
    EXPECT_EQ(result.inliers.size(), 120u);
  }
  CameraModel model = world.Model();
  for (Camera& camera : model.cameras) camera.image = camera.image.substr(0, 8) + ".PNG";
  EXPECT_EQ(ComputeGeoreference(model, track, std::nullopt).inliers.size(), 120u);
}

TEST(Georeference, NamesThatStandForTwoImagesAreNotUsed) {
  const FlightWorld world;
  GpsTrack track = world.MetricTrack(world.NoNoise());
  GpsFix other = track.fixes[5];
  track.fixes[5].image = "a/" + other.image;
  other.image = "b/" + other.image;
  track.fixes.push_back(other);
  const Georeference result = ComputeGeoreference(world.Model(), track, std::nullopt);
  EXPECT_EQ(result.inliers.size(), 119u);
}

TEST(Georeference, NoInterpolationAcrossGaps) {
  const FlightWorld world;
  GpsTrack track = world.Track(world.NoNoise());
  ImageTimes times = world.Times();
  for (double& time : times.times) time += 0.5;
  track.fixes.erase(track.fixes.begin() + 10, track.fixes.begin() + 20);
  const Georeference result = ComputeGeoreference(world.Model(), track, times, world.Options());
  // Cameras 9 to 19 lie in the gap, the last one behind the end.
  EXPECT_EQ(result.fixes.size(), 108u);
  for (const CameraFix& fix : result.fixes) EXPECT_TRUE(fix.camera < 9 || fix.camera > 19);
}

TEST(Georeference, AStraightLineIsDegenerate) {
  const FlightWorld world;
  std::mt19937_64 rng(2);
  for (const double sigma : {0.0, 0.5}) {
    CameraModel model = world.Model();
    GpsTrack track = world.MetricTrack(world.Noise(&rng, Eigen::Vector3d::Constant(sigma)));
    for (std::size_t k = 0; k < model.cameras.size(); ++k) {
      const Eigen::Vector3d x_in_world(0.6 * static_cast<double>(k), 0.3 * static_cast<double>(k),
                                       40.0 + 0.2 * std::sin(static_cast<double>(k)));
      const Eigen::Vector3d noise = track.fixes[k].metric - world.At(2.0 * static_cast<double>(k));
      const Eigen::Vector3d exact =
          sigma > 0.0 ? x_in_world : Eigen::Vector3d(x_in_world.x(), 0, 0);
      Camera& camera = model.cameras[k];
      camera.camera_from_model.translation =
          -(camera.camera_from_model.rotation * (world.world_from_map.Inverse() * exact));
      track.fixes[k].metric = exact + noise;
    }
    const Georeference result = ComputeGeoreference(model, track, std::nullopt);
    EXPECT_EQ(result.status, "degenerate") << sigma;
    EXPECT_THAT(result.reason, HasSubstr("straight line"));
    EXPECT_TRUE(result.has_estimate);
    EXPECT_NEAR(result.world_from_map.scale / world.world_from_map.scale, 1.0, 0.02);
  }
}

TEST(Georeference, AClusterIsDegenerate) {
  const FlightWorld world;
  std::mt19937_64 rng(2);
  CameraModel model = world.Model();
  GpsTrack track = world.Track(world.Noise(&rng, {30, 30, 60}));
  const Georeference result = ComputeGeoreference(model, track, world.Times(), world.Options());
  EXPECT_EQ(result.status, "degenerate");
  EXPECT_THAT(result.reason, HasSubstr("clustered"));
  EXPECT_GT(result.sigma_scale, 0.1);
}

TEST(Georeference, OnePlaceAloneIsDegenerate) {
  const FlightWorld world;
  CameraModel model = world.Model();
  GpsTrack track = world.MetricTrack(world.NoNoise());
  for (Camera& camera : model.cameras) camera.camera_from_model.translation.setZero();
  EXPECT_NE(ComputeGeoreference(model, track, std::nullopt).status, "ok");
  for (GpsFix& fix : track.fixes) fix.metric = {1, 2, 3};
  EXPECT_NE(ComputeGeoreference(model, track, std::nullopt).status, "ok");
  EXPECT_NE(ComputeGeoreference(world.Model(), track, std::nullopt).status, "ok");
}

TEST(Georeference, TwoPositionsAreTooFew) {
  const FlightWorld world;
  GpsTrack track = world.MetricTrack(world.NoNoise());
  track.fixes.resize(2);
  for (const char* method : {"robust", "paper"}) {
    GeoreferenceOptions options;
    options.method = method;
    const Georeference result = ComputeGeoreference(world.Model(), track, std::nullopt, options);
    EXPECT_EQ(result.status, "degenerate");
    EXPECT_THAT(result.reason, HasSubstr("only 2 of 120"));
    EXPECT_FALSE(result.has_estimate);
    EXPECT_EQ(result.fixes.size(), 2u);
  }
}

TEST(Georeference, ThreeExactPositionsAreEnough) {
  const FlightWorld world;
  GpsTrack track = world.MetricTrack(world.NoNoise());
  track.fixes = {track.fixes[0], track.fixes[10], track.fixes[40]};
  const Georeference result = ComputeGeoreference(world.Model(), track, std::nullopt);
  EXPECT_EQ(result.status, "ok") << result.reason;
  EXPECT_LT(world.ErrorOf(result.world_from_map).norm(), 1e-6);
}

TEST(Georeference, InputsThatDoNotFitTogether) {
  const FlightWorld world;
  const GpsTrack track = world.Track(world.NoNoise());
  EXPECT_THROW(ComputeGeoreference(world.Model(), track, std::nullopt), UsageError);
  CameraModel nameless = world.Model();
  for (Camera& camera : nameless.cameras) camera.image.clear();
  const GpsTrack by_image = world.MetricTrack(world.NoNoise());
  EXPECT_THROW(ComputeGeoreference(nameless, by_image, std::nullopt), UsageError);
  EXPECT_EQ(ComputeGeoreference(nameless, by_image, world.Times()).status, "ok");
  ImageTimes times = world.Times();
  times.times.pop_back();
  times.files.pop_back();
  try {
    ComputeGeoreference(world.Model(), track, times);
    FAIL();
  } catch (const InputError& error) {
    EXPECT_THAT(error.what(), HasSubstr("119 images, but there are 120 cameras"));
  }
  GeoreferenceOptions options;
  options.method = "best";
  EXPECT_THROW(ComputeGeoreference(world.Model(), track, world.Times(), options), UsageError);
}

TEST(Georeference, RealFlightsAndASimulatedOne) {
  const std::string base = PLANEGRAPH_SHARED_DATA;
  if (!std::filesystem::exists(base + "/photogrammetry")) GTEST_SKIP() << "no " << base;
  const std::string beach = base + "/photogrammetry/brighton_beach/";
  for (const char* gps : {"gps_exif.csv", "images"}) {
    const Georeference result =
        ComputeGeoreference(ReadCameras(beach + "colmap"), ReadGps(beach + gps), std::nullopt);
    EXPECT_EQ(result.status, "ok") << result.reason;
    EXPECT_LT(result.rms, 0.6);
  }
  const std::string church = base + "/photogrammetry/herz_jesus/";
  const Georeference result = ComputeGeoreference(
      ReadCameras(church + "colmap"), ReadGps(church + "camera_centres_truth.csv"), std::nullopt);
  EXPECT_EQ(result.status, "ok") << result.reason;
  EXPECT_LT(result.rms, 0.01);
  const std::string yard = base + "/hybrid-site-a/uav/";
  const Georeference site =
      ComputeGeoreference(ReadCameras(yard + "mve/synth_0.out"), ReadGps(yard + "gps.csv"),
                          ReadImageTimes(yard + "images.csv"));
  EXPECT_EQ(site.status, "ok") << site.reason;
  const double error = std::log(site.world_from_map.scale / 8.508675216851513);
  EXPECT_LT(std::abs(error), 3.0 * site.sigma_scale);
  EXPECT_LT(site.sigma_scale, 0.02);
}

}  // namespace
}  // namespace planegraph
