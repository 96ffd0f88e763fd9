#include "planegraph/registration/icp.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "planegraph/geometry/rotation.h"

namespace planegraph {
namespace {

class PointScene {
 public:
  explicit PointScene(std::uint64_t seed) : rng_(seed) {}

  // Points of a rectangle: corner + a * u + b * v, a, b in [0, 1], with 1 cm of noise.
  void AddRectangle(const Eigen::Vector3d& corner, const Eigen::Vector3d& u,
                    const Eigen::Vector3d& v) {
    std::uniform_real_distribution<double> uniform;
    std::normal_distribution<double> noise(0.0, 0.01);
    const auto count = static_cast<int>(300 * u.cross(v).norm());
    for (int i = 0; i < count; ++i) {
      const double a = uniform(rng_), b = uniform(rng_), h = noise(rng_);
      points_.push_back(corner + a * u + b * v + h * u.cross(v).normalized());
    }
  }

  // An axis-aligned box without its bottom.
  void AddBox(const Eigen::Vector3d& low, const Eigen::Vector3d& size) {
    const Eigen::Vector3d x(size.x(), 0, 0), y(0, size.y(), 0), z(0, 0, size.z());
    AddRectangle(low, y, z);
    AddRectangle(low + x, y, z);
    AddRectangle(low, x, z);
    AddRectangle(low + y, x, z);
    AddRectangle(low + z, x, y);
  }

  void AddCorridor(double from, double to) {
    const Eigen::Vector3d x(to - from, 0, 0), y(0, 2.4, 0), z(0, 0, 2.5), corner(from, -1.2, 0);
    AddRectangle(corner, x, y);
    AddRectangle(corner, x, z);
    AddRectangle(corner + y, x, z);
  }

  Cloud SeenFrom(const Rigid3& world_from_scan) const {
    Cloud cloud;
    const Rigid3 scan_from_world = world_from_scan.Inverse();
    for (const auto& p : points_) cloud.points.emplace_back((scan_from_world * p).cast<float>());
    return cloud;
  }

 private:
  std::mt19937_64 rng_;
  std::vector<Eigen::Vector3d> points_;
};

const Rigid3 kTarget({1, 0, 0, 0}, {0.0, 0.0, 1.0});
const Rigid3 kSource(ExpSO3(Eigen::Vector3d(0, 0, 0.4)), {0.8, 0.2, 1.0});

PointScene CorridorWithClutter(std::uint64_t seed) {
  PointScene scene(seed);
  scene.AddCorridor(-6, 6);
  scene.AddBox({2, -1.2, 0}, {0.8, 0.5, 1.2});
  scene.AddBox({-3, 0.6, 0}, {0.6, 0.6, 0.9});
  scene.AddBox({0.5, 0.9, 0.2}, {0.3, 0.3, 1.6});
  return scene;
}

TEST(IcpTest, ClutterGivesTheTranslationAlongACorridor) {
  const Cloud target = CorridorWithClutter(1).SeenFrom(kTarget);
  const Cloud source = CorridorWithClutter(2).SeenFrom(kSource);
  const Rigid3 truth = kTarget.Inverse() * kSource;
  for (const double error : {-0.3, 0.25}) {
    Rigid3 start = truth;
    start.translation.x() += error;
    const auto refined = RefineTranslation(target, source, start, {Eigen::Vector3d::UnitX()});
    EXPECT_TRUE(refined.converged) << refined.reason;
    EXPECT_TRUE(refined.featureless.empty());
    EXPECT_NEAR(refined.translation.x(), truth.translation.x(), 0.03);
    // The rest stays as it was, and is not claimed to be known.
    EXPECT_EQ(refined.translation.y(), truth.translation.y());
    EXPECT_EQ(refined.translation.z(), truth.translation.z());
    EXPECT_GT(refined.information(0, 0), 0.0);
    EXPECT_LE(refined.information(0, 0), 2500.0 * (1 + 1e-9));
    EXPECT_NEAR(refined.information(1, 1), 0.0, 1e-9);
  }
}

TEST(IcpTest, FeaturelessCorridorIsNotMoved) {
  PointScene a(3), b(4);
  a.AddCorridor(-8, 8);
  b.AddCorridor(-7.3, 8.9);
  Rigid3 start = kTarget.Inverse() * kSource;
  start.translation.x() += 0.3;
  const auto refined = RefineTranslation(a.SeenFrom(kTarget), b.SeenFrom(kSource), start,
                                         {Eigen::Vector3d::UnitX()});
  EXPECT_EQ(refined.translation, start.translation);
  EXPECT_TRUE(refined.information.isZero());
  ASSERT_EQ(refined.featureless.size(), 1u);
  EXPECT_NEAR(std::abs(refined.featureless[0].x()), 1.0, 1e-9);
  EXPECT_FALSE(refined.converged);
  EXPECT_FALSE(refined.reason.empty());
}

TEST(IcpTest, TwoOpenDirectionsOfWhichOneIsKnown) {
  PointScene a(3), b(4);
  a.AddCorridor(-8, 8);
  b.AddCorridor(-8, 8);
  const Rigid3 truth = kTarget.Inverse() * kSource;
  Rigid3 start = truth;
  start.translation += Eigen::Vector3d(0.1, 0.15, 0);
  const double c = std::cos(0.5), s = std::sin(0.5);
  const auto refined =
      RefineTranslation(a.SeenFrom(kTarget), b.SeenFrom(kSource), start, {{c, s, 0}, {-s, c, 0}});
  ASSERT_EQ(refined.featureless.size(), 1u);
  EXPECT_NEAR(std::abs(refined.featureless[0].x()), 1.0, 0.01);
  EXPECT_NEAR(refined.translation.y(), truth.translation.y(), 0.02);
  EXPECT_NEAR(refined.translation.x(), start.translation.x(), 0.02);
  EXPECT_NEAR(refined.information(2, 2), 0.0, 1e-6);
}

TEST(IcpTest, NothingInReachChangesNothing) {
  const Cloud target = CorridorWithClutter(1).SeenFrom(kTarget);
  const Rigid3 far({1, 0, 0, 0}, {100, 0, 0});
  for (const Cloud& source : {target, Cloud()}) {
    const auto refined = RefineTranslation(target, source, far, {Eigen::Vector3d::UnitX()});
    EXPECT_EQ(refined.translation, far.translation);
    EXPECT_EQ(refined.featureless.size(), 1u);
  }
  EXPECT_EQ(RefineTranslation(target, target, far, {}).translation, far.translation);
}

}  // namespace
}  // namespace planegraph
