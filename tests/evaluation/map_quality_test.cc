#include "planegraph/evaluation/map_quality.h"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <cmath>
#include <filesystem>
#include <numbers>
#include <random>

#include "planegraph/base/error.h"
#include "planegraph/evaluation/scan_merge.h"
#include "planegraph/geometry/moments.h"
#include "planegraph/geometry/rotation.h"
#include "planegraph/io/cloud_io.h"

namespace planegraph {
namespace {

// A floor and a wall with noise, dense enough for cells of several sizes.
Cloud Corner(std::size_t count, double noise, unsigned seed = 3) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<float> place(-1.0f, 1.0f);
  std::normal_distribution<float> error(0.0f, static_cast<float>(noise));
  Cloud cloud;
  for (std::size_t i = 0; i < count; ++i) {
    const float a = place(random), b = place(random), e = error(random);
    cloud.points.emplace_back(i % 2 ? Eigen::Vector3f(a, b, e) : Eigen::Vector3f(e, a, b));
  }
  return cloud;
}

struct Direct {
  double mme = 0.0, thickness = 0.0;
  std::size_t used = 0;
};

// The definition, by looking at every pair of points.
Direct BruteForce(const Cloud& cloud, double radius, std::size_t least) {
  Direct result;
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    Moments moments;
    for (std::size_t k = 0; k < cloud.size(); ++k) {
      const Eigen::Vector3d d = cloud.Position(k) - cloud.Position(i);
      if (d.squaredNorm() <= radius * radius) moments.Add(d);
    }
    if (moments.count < static_cast<double>(least)) continue;
    const Eigen::Matrix3d covariance = moments.scatter / moments.count;
    const double scale = 2.0 * std::numbers::pi * std::numbers::e;
    result.mme += 0.5 * std::log((scale * covariance).determinant());
    result.thickness += std::sqrt(ComputePrincipalAxes(covariance).values[0]);
    ++result.used;
  }
  result.mme /= static_cast<double>(result.used);
  result.thickness /= static_cast<double>(result.used);
  return result;
}

MapQualityOptions Radius(double radius) {
  MapQualityOptions options;
  options.radius = radius;
  return options;
}

TEST(MapQuality, EqualsTheDefinitionAtEveryCellSize) {
  const Cloud cloud = Corner(3000, 0.01);
  // From a handful of neighbours to all points: the number of cells per radius goes from 1 to 8.
  for (double radius : {0.08, 0.2, 0.5, 1.5, 5.0}) {
    const Direct direct = BruteForce(cloud, radius, 15);
    const MapQuality quality = ComputeMapQuality(cloud, Radius(radius));
    EXPECT_EQ(quality.used, direct.used) << radius;
    EXPECT_EQ(quality.used + quality.failed, cloud.size());
    EXPECT_NEAR(quality.mme, direct.mme, 1e-5) << radius;
    EXPECT_NEAR(quality.thickness_mean, direct.thickness, 1e-7) << radius;
  }
}

TEST(MapQuality, DoesNotDependOnThreads) {
  const Cloud cloud = Corner(20000, 0.01);
  MapQualityOptions options = Radius(0.2);
  options.threads = 1;
  const MapQuality one = ComputeMapQuality(cloud, options);
  options.threads = 5;
  const MapQuality five = ComputeMapQuality(cloud, options);
  EXPECT_EQ(one.mme, five.mme);
  EXPECT_EQ(one.mpv, five.mpv);
  EXPECT_EQ(one.thickness_mean, five.thickness_mean);
  EXPECT_EQ(one.thickness_median, five.thickness_median);
}

TEST(MapQuality, SurvivesAFarOffset) {
  Cloud cloud = Corner(3000, 0.01);
  const MapQuality near = ComputeMapQuality(cloud, Radius(0.3));
  cloud.offset = {4.0e5, 5.7e6, 120.0};
  EXPECT_EQ(ComputeMapQuality(cloud, Radius(0.3)).mme, near.mme);
}

// The balls of a scaled cloud with a scaled radius hold the same points: +3 ln s.
TEST(MapQuality, ScalingAddsThreeLogarithms) {
  Cloud cloud = Corner(3000, 0.01);
  const MapQuality before = ComputeMapQuality(cloud, Radius(0.3));
  for (auto& p : cloud.points) p *= 4.0f;
  const MapQuality after = ComputeMapQuality(cloud, Radius(1.2));
  EXPECT_EQ(after.used, before.used);
  EXPECT_NEAR(after.mme - before.mme, 3.0 * std::log(4.0), 1e-6);
  EXPECT_NEAR(after.thickness_median, 4.0 * before.thickness_median, 1e-6);
}

// Of normal errors the largest quarter of the magnitudes has the mean 4 phi(q) 2 sigma with
// q the 87.5 % quantile.
TEST(MapQuality, PlaneOfKnownNoise) {
  std::mt19937 random(11);
  std::uniform_real_distribution<float> place(-1.0f, 1.0f);
  constexpr double kSigma = 0.001;
  std::normal_distribution<float> error(0.0f, static_cast<float>(kSigma));
  Cloud cloud;
  for (int i = 0; i < 20000; ++i)
    cloud.points.emplace_back(place(random), place(random), error(random));
  const MapQuality quality = ComputeMapQuality(cloud, Radius(0.3));
  const double quantile = 1.1503493803760079;
  const double density = std::exp(-0.5 * quantile * quantile) / std::sqrt(2 * std::numbers::pi);
  EXPECT_NEAR(quality.mpv, 8.0 * density * kSigma, 0.02 * kSigma);
  EXPECT_NEAR(quality.thickness_median, kSigma, 0.02 * kSigma);
}

// A quarter of the points, far from the plane, must not turn it.
TEST(MapQuality, PlaneIsRobust) {
  std::mt19937 random(5);
  std::uniform_real_distribution<float> place(-0.1f, 0.1f);
  Cloud cloud;
  for (int i = 0; i < 400; ++i) {
    cloud.points.emplace_back(place(random), place(random), i % 4 ? 0.0f : 0.5f + place(random));
  }
  const MapQuality quality = ComputeMapQuality(cloud, Radius(10.0));
  EXPECT_NEAR(quality.mpv, 0.5, 0.02);
}

TEST(MapQuality, ModesCountFailuresDifferently) {
  Cloud cloud = Corner(3000, 0.01);
  const MapQuality alone = ComputeMapQuality(cloud, Radius(0.3));
  for (int i = 0; i < 1000; ++i) cloud.points.emplace_back(100.0f + 2.0f * i, 0.0f, 0.0f);
  MapQualityOptions options = Radius(0.3);
  const MapQuality clean = ComputeMapQuality(cloud, options);
  EXPECT_NEAR(clean.mme, alone.mme, 1e-9);
  EXPECT_EQ(clean.failed, alone.failed + 1000);
  options.mode = MapQualityMode::kTool;
  const MapQuality tool = ComputeMapQuality(cloud, options);
  EXPECT_EQ(tool.failed, 1000u);
  EXPECT_NEAR(tool.mme, BruteForce(Corner(3000, 0.01), 0.3, 1).mme * 3000 / 4000, 1e-4);
}

TEST(MapQuality, EveryTakesEveryKthPoint) {
  const Cloud cloud = Corner(3000, 0.01);
  MapQualityOptions options = Radius(0.3);
  options.every = 7;
  const MapQuality quality = ComputeMapQuality(cloud, options);
  EXPECT_EQ(quality.evaluated, 429u);
  EXPECT_EQ(quality.points, 3000u);
  EXPECT_NEAR(quality.mme, ComputeMapQuality(cloud, Radius(0.3)).mme, 0.1);
}

TEST(MapQuality, WithoutAResult) {
  EXPECT_THROW(ComputeMapQuality(Cloud(), Radius(0.3)), NoResultError);
  EXPECT_THROW(ComputeMapQuality(Corner(100, 0.01), Radius(1e-4)), NoResultError);
  EXPECT_THROW(ComputeMapQuality(Corner(100, 0.01), Radius(0.0)), UsageError);
  EXPECT_THROW(ComputeMapQuality(Corner(100, 0.01), Radius(1e-12)), UsageError);
}

TEST(MapQuality, EqualsThePublishedTool) {
  const std::string file = std::string(PLANEGRAPH_SHARED_DATA) + "/map_quality/test_pcd.pcd";
  if (!std::filesystem::exists(file)) GTEST_SKIP() << "the cloud is not here";
  const Cloud cloud = ReadCloud(file);
  MapQualityOptions options = Radius(0.3);
  options.plane_variance = false;
  EXPECT_NEAR(ComputeMapQuality(cloud, options).mme, -5.00148, 2e-5);
  options.plane_variance = true;
  options.mode = MapQualityMode::kTool;
  // The points lie on a lattice: a prime step takes them from all over it.
  options.every = 17;
  const MapQuality tool = ComputeMapQuality(cloud, options);
  EXPECT_NEAR(tool.mpv, 0.0159494, 0.02 * 0.0159494);
}

TEST(ScanMerger, KeepsTheFirstPointOfEachVoxel) {
  Cloud cloud;
  cloud.points = {{0.01f, 0, 0}, {0.09f, 0, 0}, {-0.01f, 0, 0}, {0.11f, 0, 0}, {0.02f, 0.05f, 0}};
  EXPECT_EQ(FirstOfEachVoxel(cloud, 0.1), (std::vector<std::uint32_t>{0, 2, 3}));
  EXPECT_THROW(FirstOfEachVoxel(cloud, 1e-9), UsageError);
}

TEST(ScanMerger, DropsNearAndFarPointsAndPlacesTheRest) {
  Cloud scan;
  scan.points = {{0.4f, 0, 0}, {1, 0, 0}, {0, 2, 0}, {0, 0, 50}};
  ScanMerger merger({0.0, 0.5, 30.0});
  const Rigid3 world_from_scan(ExpSO3({0, 0, std::numbers::pi / 2}), {1.0e6, 2.0e6, 0});
  merger.Add(scan, world_from_scan);
  merger.Add(scan, {});
  const Cloud& merged = merger.merged();
  ASSERT_EQ(merged.size(), 4u);
  EXPECT_LT((merged.Position(0) - Eigen::Vector3d(1.0e6, 2.0e6 + 1, 0)).norm(), 1e-6);
  EXPECT_LT((merged.Position(1) - Eigen::Vector3d(1.0e6 - 2, 2.0e6, 0)).norm(), 1e-6);
}

}  // namespace
}  // namespace planegraph
