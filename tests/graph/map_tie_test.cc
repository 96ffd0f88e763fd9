// What ties two maps, or two tiles of one: which motions it punishes, and which not.
#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "planegraph/geometry/rotation.h"
#include "planegraph/graph/factor_registry.h"
#include "planegraph/graph/factor_sampling.h"
#include "planegraph/graph/graph.h"

namespace planegraph {
namespace {

using Eigen::Vector3d;

MapFactor Tie(const Sim3& target_from_source, const Vector3d& point) {
  MapFactor factor;
  factor.type = "map_tie";
  factor.maps = {0, 1};
  factor.measurement = target_from_source;
  factor.point = point;
  return factor;
}

Vector7d Residual(const MapFactor& factor, const Sim3& target, const Sim3& source) {
  const auto cost = BuiltinFactors().Get("map_tie", FactorKind::kMap).make_map_cost(factor);
  const auto a = FactorSampler::Block(target), b = FactorSampler::Block(source);
  const double* blocks[] = {a.data(), b.data()};
  Vector7d residual;
  EXPECT_TRUE(cost->Evaluate(blocks, residual.data(), nullptr));
  return residual;
}

// Maps that are tied about a point, and disturbed from where the tie has them.
struct Pair {
  explicit Pair(std::uint64_t seed) {
    std::mt19937_64 rng(seed);
    std::uniform_real_distribution<double> any(-1.0, 1.0);
    const auto vector = [&](double size) {
      const double x = any(rng), y = any(rng), z = any(rng);
      return Vector3d(size * x, size * y, size * z);
    };
    target = Sim3(std::exp(any(rng)), ExpSO3(vector(3.0)), vector(50.0));
    measurement = Sim3(std::exp(any(rng)), ExpSO3(vector(3.0)), vector(50.0));
    point = vector(20.0);
    const Sim3 exact = target * measurement;
    source = Sim3(exact.scale * std::exp(0.01 * any(rng)), ExpSO3(vector(0.01)) * exact.rotation,
                  exact.translation + vector(0.1));
    other = Sim3(std::exp(any(rng)), ExpSO3(vector(3.0)), vector(50.0));
  }
  Sim3 target, source, measurement, other;
  Vector3d point;
};

TEST(MapTie, IsZeroWhereTheMeasurementHolds) {
  for (std::uint64_t seed = 0; seed < 20; ++seed) {
    const Pair p(seed);
    EXPECT_LT(Residual(Tie(p.measurement, p.point), p.target, p.target * p.measurement).norm(),
              1e-7);
  }
}

TEST(MapTie, TargetAndSourceMayChangePlaces) {
  for (std::uint64_t seed = 0; seed < 20; ++seed) {
    const Pair p(seed);
    const Sim3 back = p.measurement.Inverse();
    EXPECT_NEAR(Residual(Tie(p.measurement, p.point), p.target, p.source).norm(),
                Residual(Tie(back, back * p.point), p.source, p.target).norm(), 1e-7);
  }
}

TEST(MapTie, AMotionOfTheWorldChangesNothing) {
  for (std::uint64_t seed = 0; seed < 20; ++seed) {
    const Pair p(seed);
    const Sim3 moved(1.0, p.other.rotation, p.other.translation);
    const MapFactor tie = Tie(p.measurement, p.point);
    EXPECT_LT(
        (Residual(tie, p.target, p.source) - Residual(tie, moved * p.target, moved * p.source))
            .norm(),
        1e-7);
  }
}

TEST(MapTie, AnotherFrameOfTheMapsChangesOnlyAxes) {
  for (std::uint64_t seed = 0; seed < 20; ++seed) {
    const Pair p(seed);
    const Sim3 moved = p.other.Inverse();  // old from new
    const Sim3 between = p.other * p.measurement * moved;
    const Vector7d old = Residual(Tie(p.measurement, p.point), p.target, p.source);
    const Vector7d now =
        Residual(Tie(between, p.other * p.point), p.target * moved, p.source * moved);
    EXPECT_NEAR(old.head<3>().norm(), now.head<3>().norm(), 1e-6);
    EXPECT_NEAR(old.segment<3>(3).norm(), now.segment<3>(3).norm(), 1e-6);
    EXPECT_NEAR(old[6], now[6], 1e-7);
  }
}

TEST(MapTie, ATurnAboutTheCommonPointMovesNothing) {
  // The origin of both is a kilometre away.
  const Vector3d point(1000.0, 0.0, 0.0);
  const Sim3 target;
  const double angle = 0.002, scale = 1.01;  // the information is the identity
  const Eigen::Quaterniond turn = ExpSO3({0.0, 0.0, angle});
  const Sim3 source(scale, turn, point - scale * (turn * point));
  const Vector7d residual = Residual(Tie(Sim3(), point), target, source);
  EXPECT_LT(residual.head<3>().norm(), 1e-9);
  EXPECT_NEAR(residual.segment<3>(3).norm(), angle, 1e-9);
  EXPECT_NEAR(residual[6], std::log(scale), 1e-9);
}

}  // namespace
}  // namespace planegraph
