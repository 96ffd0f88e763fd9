#include "planegraph/graph/manifolds.h"

#include <ceres/manifold_test_utils.h>
#include <gtest/gtest.h>

#include "planegraph/geometry/rotation.h"
#include "planegraph/graph/factor_sampling.h"
#include "planegraph/graph/plane_charts.h"

namespace planegraph {
namespace {

using namespace ceres;  // the matchers of the macro are called without their namespace

constexpr double kTolerance = 1e-9;
constexpr int kTrials = 50;

// The Minus of an almost opposite element is not compared: delta stays well below pi.
Vector Tangent(FactorSampler* sampler, int size) {
  Vector delta(size);
  for (int k = 0; k < size; ++k) delta[k] = sampler->Uniform(-1.0, 1.0);
  return delta;
}

TEST(Se3Manifold, InvariantsHold) {
  std::mt19937_64 rng(1);
  for (int trial = 0; trial < kTrials; ++trial) {
    FactorSampler sampler(&rng);
    const Rigid3 pose(sampler.Rotation(), sampler.UnitVector());
    const Rigid3 other(ExpSO3(0.9 * sampler.UnitVector()) * pose.rotation, sampler.UnitVector());
    const auto x_block = FactorSampler::Block(pose), y_block = FactorSampler::Block(other);
    const Vector x = Eigen::Map<const Vector>(x_block.data(), 7);
    const Vector y = Eigen::Map<const Vector>(y_block.data(), 7);
    EXPECT_THAT_MANIFOLD_INVARIANTS_HOLD(Se3Manifold(), x, Tangent(&sampler, 6), y, kTolerance);
  }
}

TEST(Sim3Manifold, InvariantsHold) {
  std::mt19937_64 rng(4);
  for (int trial = 0; trial < kTrials; ++trial) {
    FactorSampler sampler(&rng);
    const Sim3 map(2.0, sampler.Rotation(), sampler.UnitVector());
    const Sim3 other(0.5, ExpSO3(0.9 * sampler.UnitVector()) * map.rotation, sampler.UnitVector());
    const auto x_block = FactorSampler::Block(map), y_block = FactorSampler::Block(other);
    const Vector x = Eigen::Map<const Vector>(x_block.data(), 8);
    const Vector y = Eigen::Map<const Vector>(y_block.data(), 8);
    EXPECT_THAT_MANIFOLD_INVARIANTS_HOLD(Sim3Manifold(), x, Tangent(&sampler, 7), y, kTolerance);
  }
}

TEST(UnitVectorManifold, InvariantsHold) {
  std::mt19937_64 rng(2);
  for (int trial = 0; trial < kTrials; ++trial) {
    FactorSampler sampler(&rng);
    const Vector x = sampler.UnitVector(), y = sampler.UnitVector();
    EXPECT_THAT_MANIFOLD_INVARIANTS_HOLD(UnitVectorManifold(), x, Tangent(&sampler, 2), y,
                                         kTolerance);
  }
}

TEST(PlaneManifold, InvariantsHold) {
  std::mt19937_64 rng(3);
  for (int trial = 0; trial < kTrials; ++trial) {
    FactorSampler sampler(&rng);
    Vector x(4), y(4);
    x << sampler.UnitVector(), sampler.Uniform(-1, 1);
    y << sampler.UnitVector(), sampler.Uniform(-1, 1);
    EXPECT_THAT_MANIFOLD_INVARIANTS_HOLD(PlaneManifold(), x, Tangent(&sampler, 3), y, kTolerance);
  }
}

TEST(PlaneCharts, InvariantsHold) {
  std::mt19937_64 rng(5);
  for (int trial = 0; trial < kTrials; ++trial) {
    FactorSampler sampler(&rng);
    const Eigen::Vector3d arm = 3.0 * sampler.UnitVector();
    Vector x(4), y(4);
    x << sampler.UnitVector(), 0.0;
    x[3] = sampler.Uniform(3.0, 5.0) - x.head<3>().dot(arm);  // 3 to 5 m from the reference
    y << (x.head<3>() + 0.4 * sampler.UnitVector()).normalized(), 0.0;
    y[3] = sampler.Uniform(3.0, 5.0) - y.head<3>().dot(arm);
    const Vector small = 0.5 * Tangent(&sampler, 3);
    const auto check = [&](const Manifold& chart) {
      EXPECT_THAT_MANIFOLD_INVARIANTS_HOLD(chart, x, small, y, kTolerance);
    };
    check(ClosestPointManifold(arm));
    check(UnitQuaternionManifold(2.0));
  }
}

TEST(PlaneCharts, StepsMoveTheClosestPointAndTheQuaternion) {
  const Eigen::Vector3d arm(1.0, 2.0, -1.0);
  Vector x(4), moved(4);
  x << 0.0, 0.6, 0.8, 0.5;  // d = 0.9
  const Eigen::Vector3d step(0.1, -0.2, 0.05);
  ASSERT_TRUE(ClosestPointManifold(arm).Plus(x.data(), step.data(), moved.data()));
  const double d = moved[3] + moved.head<3>().dot(arm);
  EXPECT_LT((d * moved.head<3>() - Eigen::Vector3d(0.1, 0.34, 0.77)).norm(), 1e-12);
  const UnitQuaternionManifold quaternion(0.5);
  const Eigen::Vector3d half_turn(0.0, 0.0, EIGEN_PI / 2.0);  // q k, q = (0, 0.6, 0.8, 1) / sqrt 2
  ASSERT_TRUE(quaternion.Plus(x.data(), half_turn.data(), moved.data()));
  EXPECT_LT((moved.head<3>() - Eigen::Vector3d(0.6, 0.0, 1.0).normalized()).norm(), 1e-12);
}

TEST(Se3Manifold, TangentIsTheDecoupledLeftPerturbationInMetresAndRadians) {
  const Rigid3 pose(ExpSO3({0.3, -0.2, 1.0}), {1, 2, 3});
  const auto block = FactorSampler::Block(pose);
  const double delta[6] = {0.1, 0.2, 0.3, 0.0, 0.0, 0.5};
  double moved[7];
  Se3Manifold().Plus(block.data(), delta, moved);
  const Rigid3 result = PoseFromBlock(moved);
  EXPECT_LT((result.translation - Eigen::Vector3d(1.1, 2.2, 3.3)).norm(), 1e-14);
  const Eigen::Quaterniond expected = ExpSO3({0, 0, 0.5}) * pose.rotation;
  EXPECT_LT(AngleBetween(result.rotation, expected), 1e-14);
}

TEST(UnitVectorManifold, MovesByRadians) {
  const Eigen::Vector3d n = Eigen::Vector3d(1, 2, -2) / 3.0;
  Eigen::Vector3d moved;
  const Eigen::Vector2d delta(0.3, -0.4);
  UnitVectorManifold().Plus(n.data(), delta.data(), moved.data());
  EXPECT_NEAR(std::acos(n.dot(moved)), 0.5, 1e-14);
}

TEST(UnitVectorManifold, TheAntipodeIsPiAway) {
  const Eigen::Vector3d n = Eigen::Vector3d::UnitY(), opposite = -n;
  Eigen::Vector2d difference;
  UnitVectorManifold().Minus(opposite.data(), n.data(), difference.data());
  EXPECT_NEAR(difference.norm(), EIGEN_PI, 1e-12);
}

}  // namespace
}  // namespace planegraph
