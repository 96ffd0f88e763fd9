// What noise does to a georeference: outliers, honesty of the covariance, symmetries, clocks.
#include <gtest/gtest.h>

#include <algorithm>

#include "registration/flight_world.h"

namespace planegraph {
namespace {

TEST(GeoreferenceNoise, ThirtyPercentOfOutliersDoNoHarm) {
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
  constexpr int kTrials = 80;
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

// The mean of 80 squares of a standard normal variable has a standard deviation of 0.16.
TEST(GeoreferenceNoise, TheCovarianceIsHonestUnderWhiteNoise) {
  const Honesty honesty = Measure({0.7, 0.7, 1.4}, Eigen::Vector3d::Zero());
  EXPECT_GT(honesty.scale, 0.65);
  EXPECT_LT(honesty.scale, 1.35);
  EXPECT_GT(honesty.all, 5.0);
  EXPECT_LT(honesty.all, 8.5);
  EXPECT_LT(honesty.inflation, 1.5);
}

TEST(GeoreferenceNoise, TheCovarianceIsHonestUnderCorrelatedNoise) {
  const Honesty honesty = Measure({0.7, 0.7, 1.0}, {1.2, 1.2, 1.6});
  EXPECT_GT(honesty.scale, 0.5);
  EXPECT_LT(honesty.scale, 1.6);
  EXPECT_GT(honesty.all, 4.0);
  EXPECT_LT(honesty.all, 11.0);
  EXPECT_GT(honesty.inflation, 1.5);
}

TEST(GeoreferenceNoise, ASimilarityOfTheModelIsTakenUp) {
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

TEST(GeoreferenceNoise, ARigidMotionOfTheWorldIsTakenUp) {
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

// 2 sigma^2 / L of the mean distance, L = 2 m and sigma = 0.5 m: an eighth.
TEST(GeoreferenceNoise, ThePapersScaleIsInflatedByNoise) {
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

TEST(GeoreferenceNoise, ClocksThatDifferAreBroughtTogether) {
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

TEST(GeoreferenceNoise, CorrelatedNoiseIsNotTakenForADifferenceOfClocks) {
  const FlightWorld world;
  for (std::uint64_t seed = 0; seed < 10; ++seed) {
    std::mt19937_64 rng(seed);
    GeoreferenceOptions options = world.Options();
    options.max_time_offset = 20.0;
    const auto noise = world.Noise(&rng, {0.7, 0.7, 1.0}, {1.2, 1.2, 1.6});
    EXPECT_LT(std::abs(Locate(world, world.Track(noise), options).time_offset), 1.0) << seed;
  }
}

}  // namespace
}  // namespace planegraph
