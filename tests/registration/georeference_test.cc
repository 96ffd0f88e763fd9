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

Georeference Locate(const FlightWorld& world, const GpsTrack& track,
                    const GeoreferenceOptions& options) {
  return ComputeGeoreference(world.Model(), track, world.Times(), options);
}

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

TEST(Georeference, ThirtyPercentOfOutliersDoNoHarm) {
  const FlightWorld world;
  std::mt19937_64 rng(4);
  std::normal_distribution<double> normal;
  auto noise = world.Noise(&rng, {0.5, 0.5, 1.0});
  std::vector<std::size_t> spoilt;
  for (std::size_t k = 0; k < noise.size(); ++k) {
    if (k % 10 > 2) continue;
    spoilt.push_back(k);
    const Eigen::Vector3d direction = Eigen::Vector3d::NullaryExpr([&] { return normal(rng); });
    noise[k] += 20.0 * direction.normalized() + Eigen::Vector3d(10.0, 0.0, 0.0);
  }
  const Georeference result = Locate(world, world.Track(noise), world.Options());
  EXPECT_EQ(result.status, "ok") << result.reason;
  EXPECT_LT(std::abs(world.ErrorOf(result.world_from_map)[6]), 0.01);
  EXPECT_NEAR(result.sigma_horizontal, 0.5, 0.15);
  EXPECT_NEAR(result.sigma_vertical, 1.0, 0.3);
  for (const std::size_t k : spoilt) {
    EXPECT_EQ(std::count(result.inliers.begin(), result.inliers.end(), k), 0) << k;
  }
  for (const CameraFix& fix : result.fixes) {
    const bool listed =
        std::binary_search(result.inliers.begin(), result.inliers.end(), fix.camera);
    EXPECT_EQ(fix.inlier, listed);
  }
}

// Squares of the scale's error over its standard deviation, and of the whole error in the metric of
// the covariance (7 degrees of freedom), each as a mean over trials.
struct Honesty {
  double scale = 0.0, all = 0.0, inflation = 0.0;
};

Honesty Measure(const Eigen::Vector3d& white, const Eigen::Vector3d& correlated) {
  constexpr int kTrials = 150;
  const FlightWorld world;
  const CameraModel model = world.Model();
  Honesty sum;
  for (int trial = 0; trial < kTrials; ++trial) {
    std::mt19937_64 rng(static_cast<std::uint64_t>(trial));
    const GpsTrack track = world.Track(world.Noise(&rng, white, correlated));
    const Georeference result = ComputeGeoreference(model, track, world.Times(), world.Options());
    const auto error = world.ErrorOf(result.world_from_map);
    sum.scale += std::pow(error[6] / result.sigma_scale, 2) / kTrials;
    sum.all += error.dot(result.covariance.ldlt().solve(error)) / kTrials;
    sum.inflation += result.correlation_inflation / kTrials;
  }
  return sum;
}

// The mean of 150 squares of a standard normal variable has a standard deviation of 0.115.
TEST(Georeference, TheCovarianceIsHonestUnderWhiteNoise) {
  const Honesty honesty = Measure({0.7, 0.7, 1.4}, Eigen::Vector3d::Zero());
  EXPECT_GT(honesty.scale, 0.65);
  EXPECT_LT(honesty.scale, 1.35);
  EXPECT_GT(honesty.all, 5.0);
  EXPECT_LT(honesty.all, 8.5);
  EXPECT_LT(honesty.inflation, 1.5);
}

TEST(Georeference, TheCovarianceIsHonestUnderCorrelatedNoise) {
  const Honesty honesty = Measure({0.7, 0.7, 1.0}, {1.2, 1.2, 1.6});
  EXPECT_GT(honesty.scale, 0.5);
  EXPECT_LT(honesty.scale, 1.6);
  EXPECT_GT(honesty.all, 4.0);
  EXPECT_LT(honesty.all, 11.0);
  EXPECT_GT(honesty.inflation, 1.5);
}

TEST(Georeference, ASimilarityOfTheModelIsTakenUp) {
  const FlightWorld world;
  std::mt19937_64 rng(7);
  const GpsTrack track = world.Track(world.Noise(&rng, {1, 1, 2}, {1, 1, 1}));
  const Sim3 new_from_map(0.03, ExpSO3({1, 2, -0.5}), {1000, 20, -3});
  CameraModel moved = world.Model();
  for (Camera& camera : moved.cameras) {
    const Eigen::Vector3d centre = new_from_map * camera.Centre();
    camera.camera_from_model.translation = -(camera.camera_from_model.rotation * centre);
  }
  const Georeference before = Locate(world, track, world.Options());
  const Georeference after = ComputeGeoreference(moved, track, world.Times(), world.Options());
  const Sim3 expected = before.world_from_map * new_from_map.Inverse();
  EXPECT_NEAR(after.world_from_map.scale / expected.scale, 1.0, 1e-8);
  EXPECT_LT(AngleBetween(after.world_from_map.rotation, expected.rotation), 1e-8);
  EXPECT_NEAR(after.sigma_scale / before.sigma_scale, 1.0, 1e-6);
  for (const Camera& camera : moved.cameras) {
    EXPECT_LT((after.world_from_map * camera.Centre() - expected * camera.Centre()).norm(), 1e-5);
  }
}

TEST(Georeference, ARigidMotionOfTheWorldIsTakenUp) {
  const FlightWorld world;
  std::mt19937_64 rng(8);
  const GpsTrack track = world.MetricTrack(world.Noise(&rng, {0.5, 0.5, 0.5}));
  const Rigid3 moved_from_world(ExpSO3({-0.4, 1.0, 2.0}), {5e5, 5.7e6, 100});
  GpsTrack moved = track;
  for (GpsFix& fix : moved.fixes) fix.metric = moved_from_world * fix.metric;
  const auto model = world.Model();
  const Sim3 before = ComputeGeoreference(model, track, std::nullopt).world_from_map;
  const Sim3 after = ComputeGeoreference(model, moved, std::nullopt).world_from_map;
  const Sim3 expected = Sim3(moved_from_world) * before;
  EXPECT_NEAR(after.scale, expected.scale, 1e-7);
  for (const Camera& camera : model.cameras) {
    EXPECT_LT((after * camera.Centre() - expected * camera.Centre()).norm(), 1e-6);
  }
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

// 2 sigma^2 / L of the mean distance, L = 2 m and sigma = 0.5 m: an eighth.
TEST(Georeference, ThePapersScaleIsInflatedByNoise) {
  FlightWorld world;
  world.cameras = 300;
  world.spacing = 2.0 / 3.0;
  std::mt19937_64 rng(3);
  const auto model = world.Model();
  double path = 0.0;
  for (int k = 1; k < world.cameras; ++k) {
    path += (world.At(world.spacing * k) - world.At(world.spacing * (k - 1))).norm();
  }
  const double spacing = path / (world.cameras - 1), sigma = 0.25 * spacing;
  const GpsTrack track = world.Track(world.Noise(&rng, Eigen::Vector3d::Constant(sigma)));
  GeoreferenceOptions options = world.Options();
  const double robust = Locate(world, track, options).world_from_map.scale;
  options.method = "paper";
  const double paper = Locate(world, track, options).world_from_map.scale;
  EXPECT_GT(paper / world.world_from_map.scale, 1.09);
  EXPECT_LT(paper / world.world_from_map.scale, 1.20);
  EXPECT_NEAR(robust / world.world_from_map.scale, 1.0, 0.01);
}

TEST(Georeference, ClocksThatDifferAreBroughtTogether) {
  const FlightWorld world;
  std::mt19937_64 rng(5);
  for (const double offset : {0.0, 1.5, -18.0}) {
    GpsTrack track = world.Track(world.Noise(&rng, {0.3, 0.3, 0.6}));
    for (GpsFix& fix : track.fixes) fix.time += offset;
    GeoreferenceOptions options = world.Options();
    options.max_time_offset = 20.0;
    const Georeference result = Locate(world, track, options);
    EXPECT_EQ(result.status, "ok") << result.reason;
    EXPECT_NEAR(result.time_offset, offset, 0.1);
    if (offset == 0.0) {
      EXPECT_EQ(result.time_offset, 0.0);
    }
    EXPECT_LT(std::abs(world.ErrorOf(result.world_from_map)[6]), 0.01);
  }
}

TEST(Georeference, CorrelatedNoiseIsNotTakenForADifferenceOfClocks) {
  const FlightWorld world;
  for (std::uint64_t seed = 0; seed < 10; ++seed) {
    std::mt19937_64 rng(seed);
    GeoreferenceOptions options = world.Options();
    options.max_time_offset = 20.0;
    const auto noise = world.Noise(&rng, {0.7, 0.7, 1.0}, {1.2, 1.2, 1.6});
    EXPECT_LT(std::abs(Locate(world, world.Track(noise), options).time_offset), 1.0) << seed;
  }
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
  for (const auto& [before, after] : {std::pair<std::string, std::string>{"", "left/"}, {"", ""}}) {
    CameraModel model = world.Model();
    for (Camera& camera : model.cameras) camera.image = before + after + camera.image;
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
