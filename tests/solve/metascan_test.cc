#include "planegraph/solve/metascan.h"

#include <gtest/gtest.h>

#include <ctime>
#include <numbers>
#include <random>

#include "planegraph/base/error.h"
#include "planegraph/geometry/rotation.h"
#include "registration/plane_rooms.h"
#include "solve/metascan_map.h"

namespace planegraph {
namespace {

struct Drive {
  std::vector<PlaneSet> scans;
  std::vector<Rigid3> truth, start;
};

// Scans on a circle in the hall with drifting odometry.
Drive MakeDrive(int scans, const std::vector<Rectangle>& scene, double drift) {
  Drive run;
  std::mt19937_64 rng(11);
  std::normal_distribution<double> normal;
  Rigid3 last;
  for (int k = 0; k < scans; ++k) {
    const double a = 2 * std::numbers::pi * k / scans;
    const Rigid3 pose(ExpSO3(Eigen::Vector3d(0, 0, a)),
                      Eigen::Vector3d(3 * std::cos(a) - 3, 3 * std::sin(a), 0));
    run.scans.push_back(Measure(scene, pose, 5e-4, 2e-3, 100 + k));
    if (k == 0) {
      run.start.push_back(pose);
    } else {
      const double x = normal(rng), y = normal(rng), turn = normal(rng);
      const Rigid3 error(ExpSO3(Eigen::Vector3d(0, 0, 0.01 * drift * turn)),
                         drift * Eigen::Vector3d(0.05 * x, 0.05 * y, 0.01));
      run.start.push_back(run.start.back() * (last.Inverse() * pose) * error);
    }
    run.truth.push_back(pose);
    last = pose;
  }
  return run;
}

double LargestError(const std::vector<Rigid3>& a, const std::vector<Rigid3>& b) {
  double largest = 0;
  for (std::size_t i = 0; i < a.size(); ++i) {
    largest = std::max(largest, (a[i].translation - b[i].translation).norm());
  }
  return largest;
}

TEST(MetascanTest, BringsDriftingScansTogether) {
  const Drive run = MakeDrive(8, Hall(), 1.0);
  const double before = LargestError(run.start, run.truth);
  const MetascanResult result = OptimizeMetascan(run.scans, run.start);
  EXPECT_TRUE(result.terminated);
  EXPECT_TRUE(result.alone.empty());
  EXPECT_GE(result.pops, 7u);
  EXPECT_GT(before, 0.1);
  EXPECT_LT(LargestError(result.poses, run.truth), 0.015);
  EXPECT_EQ(result.poses[0].translation, run.start[0].translation);
}

TEST(MetascanTest, OpenDirectionStaysWithTheOdometry) {
  Drive run = MakeDrive(3, Corridor(), 0.0);
  for (int k = 0; k < 3; ++k) run.start[k].translation += k * Eigen::Vector3d(0.05, 0.04, 0.0);
  const auto poses = OptimizeMetascan(run.scans, run.start).poses;
  for (int k = 1; k < 3; ++k) {
    EXPECT_NEAR(poses[k].translation.y(), run.truth[k].translation.y(), 0.01);
    EXPECT_NEAR(poses[k].translation.x(), run.truth[k].translation.x() + k * 0.05, 0.01);
  }
}

TEST(MetascanTest, CapEndsTheQueue) {
  const Drive run = MakeDrive(6, Hall(), 1.0);
  MetascanOptions options;
  options.most_pops_per_scan = 1;
  options.min_translation = options.min_rotation_deg = 0.0;
  const MetascanResult result = OptimizeMetascan(run.scans, run.start, options);
  EXPECT_FALSE(result.terminated);
  EXPECT_EQ(result.pops, 6u);
}

TEST(MetascanTest, LonelyScansStayAndAreNamed) {
  Drive run = MakeDrive(2, Hall(), 0.0);
  run.scans.emplace_back();
  run.start.emplace_back();
  const MetascanResult result = OptimizeMetascan(run.scans, run.start);
  ASSERT_EQ(result.alone.size(), 1u);
  EXPECT_EQ(result.alone[0], 2u);
  EXPECT_THROW(OptimizeMetascan(run.scans, {}), UsageError);
  EXPECT_TRUE(OptimizeMetascan({}, {}).poses.empty());
}

TEST(MetascanTest, MergingClosesGaps) {
  // Two halves of a wall, each seen by one scan, overlapping by a metre.
  const Eigen::Vector3d x(1, 0, 0), z(0, 0, 1);
  const Rigid3 a, b(ExpSO3(Eigen::Vector3d(0, 0, 0.7)), Eigen::Vector3d(1, -2, 0));
  PlaneSet right;
  right.planes.push_back(MakeSegment({{1.5, 3, 1}, x, z, 2, 1}, b.Inverse(), 0));
  PlaneSet first;
  first.planes.push_back(MakeSegment({{-1.5, 3, 1}, x, z, 2, 1}, a.Inverse(), 0));
  const auto segments_a = PlaceSegments(first, a, 0.5), segments_b = PlaceSegments(right, b, 0.5);
  auto merged = MergeSegments({&segments_a, &segments_b}, CoincidenceGate(3, 0.1, 0.0));
  ASSERT_EQ(merged.size(), 1u);
  EXPECT_NEAR(merged[0].Area(), 14.0, 0.5);
  EXPECT_NEAR(merged[0].plane.centroid.x(), 0.0, 1e-9);
  EXPECT_NEAR(merged[0].moments.count, 2 * first.planes[0].moments.count, 1e-6);
}

TEST(MetascanTest, IsFastOnALoopOfManyPlanes) {
  std::vector<Rectangle> scene = Hall();
  std::mt19937_64 rng(5);
  std::uniform_real_distribution<double> uniform(-1, 1);
  while (scene.size() < 100) {
    const double x = 9 * uniform(rng), y = 5 * uniform(rng), yaw = 3 * uniform(rng);
    const Eigen::Vector3d u(std::cos(yaw), std::sin(yaw), 0);
    scene.push_back({{x, y, 1}, u, Eigen::Vector3d::UnitZ(), 0.5, 0.8});
  }
  const Drive run = MakeDrive(24, scene, 0.3);
  const std::clock_t begin = std::clock();
  const MetascanResult result = OptimizeMetascan(run.scans, run.start);
  const double seconds = static_cast<double>(std::clock() - begin) / CLOCKS_PER_SEC;
  RecordProperty("pops", static_cast<int>(result.pops));
  RecordProperty("cpu_milliseconds", static_cast<int>(1000 * seconds));
  EXPECT_LT(LargestError(result.poses, run.truth), 0.02);
  EXPECT_LT(seconds, 5.0);  // far above what it takes, for slow machines and sanitizers
}

}  // namespace
}  // namespace planegraph
