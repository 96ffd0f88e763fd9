#include "pose_graph/edge_model.h"

#include <gtest/gtest.h>

#include "pose_graph/graphs.h"

namespace planegraph {
namespace {

template <int Dim>
double HalfChi2(const GraphPose<Dim>& from, const GraphPose<Dim>& to, const GraphEdge<Dim>& edge,
                RotationResidual kind) {
  const auto r = EdgeResidual<Dim>(from, to, edge, kind);
  return 0.5 * r.dot(edge.information * r);
}

// Central differences of 0.5 r^T information r over both poses' steps.
template <int Dim>
Eigen::MatrixXd NumericHessian(const GraphPose<Dim>& from, const GraphPose<Dim>& to,
                               const GraphEdge<Dim>& edge, RotationResidual kind) {
  constexpr int kSize = kPoseDimension<Dim>;
  constexpr double kStep = 1e-4;
  const auto cost = [&](const Eigen::VectorXd& x) {
    return HalfChi2<Dim>(Retract<Dim>(from, x.head<kSize>()), Retract<Dim>(to, x.tail<kSize>()),
                         edge, kind);
  };
  Eigen::MatrixXd hessian(2 * kSize, 2 * kSize);
  for (int i = 0; i < 2 * kSize; ++i) {
    for (int j = 0; j < 2 * kSize; ++j) {
      double sum = 0.0;
      for (const int a : {-1, 1}) {
        for (const int b : {-1, 1}) {
          Eigen::VectorXd x = Eigen::VectorXd::Zero(2 * kSize);
          x[i] += a * kStep;
          x[j] += b * kStep;
          sum += a * b * cost(x);
        }
      }
      hessian(i, j) = sum / (4.0 * kStep * kStep);
    }
  }
  return hessian;
}

template <int Dim>
void CompareWithDifferences(RotationResidual kind, std::uint64_t seed) {
  constexpr int kSize = kPoseDimension<Dim>;
  std::mt19937_64 rng(seed);
  const GraphPose<Dim> from = RandomPose<Dim>(&rng), to = RandomPose<Dim>(&rng);
  // A residual of any size, up to angles near pi (but not at it, where the sign turns).
  const GraphPose<Dim> measurement =
      Compose(Relative(from, to), Retract<Dim>({}, RandomStep<Dim>(&rng, 1.0, 0.7)));
  const GraphEdge<Dim> edge{0, 1, measurement, RandomInformation<Dim>(&rng), false};
  EdgeModel<Dim> model;
  ModelEdge<Dim>(from, to, edge, kind, true, &model);
  EXPECT_LT((model.residual - EdgeResidual<Dim>(from, to, edge, kind)).norm(), 1e-14);
  Eigen::Matrix<double, kSize, 2 * kSize> jacobian, numeric;
  jacobian << model.by_from, model.by_to;
  for (int k = 0; k < 2 * kSize; ++k) {
    Eigen::Matrix<double, 2 * kSize, 1> step = Eigen::Matrix<double, 2 * kSize, 1>::Unit(k) * 1e-6;
    const auto at = [&](double sign) {
      return EdgeResidual<Dim>(Retract<Dim>(from, sign * step.template head<kSize>()),
                               Retract<Dim>(to, sign * step.template tail<kSize>()), edge, kind);
    };
    numeric.col(k) = (at(1.0) - at(-1.0)) / 2e-6;
  }
  EXPECT_LT((jacobian - numeric).norm(), 1e-7 * (1.0 + numeric.norm())) << seed;
  Eigen::MatrixXd hessian = jacobian.transpose() * edge.information * jacobian;
  hessian.topLeftCorner(kSize, kSize) += model.curvature_from;
  hessian.bottomRightCorner(kSize, kSize) += model.curvature_to;
  hessian.topRightCorner(kSize, kSize) += model.curvature_cross;
  hessian.bottomLeftCorner(kSize, kSize) += model.curvature_cross.transpose();
  const Eigen::MatrixXd expected = NumericHessian<Dim>(from, to, edge, kind);
  EXPECT_LT((hessian - expected).norm(), 1e-5 * (1.0 + expected.norm())) << seed;
}

TEST(EdgeModel, DerivativesInSpaceAgreeWithDifferences) {
  for (std::uint64_t seed = 0; seed < 50; ++seed) {
    CompareWithDifferences<3>(RotationResidual::kHalfSine, seed);
  }
}

TEST(EdgeModel, DerivativesInThePlaneAgreeWithDifferences) {
  for (std::uint64_t seed = 0; seed < 50; ++seed) {
    CompareWithDifferences<2>(RotationResidual::kHalfSine, seed);
    CompareWithDifferences<2>(RotationResidual::kAngle, seed);
  }
}

TEST(EdgeModel, IsotropicResidualIsSeSyncsObjective) {
  std::mt19937_64 rng(3);
  for (int trial = 0; trial < 20; ++trial) {
    const GraphPose<3> from = RandomPose<3>(&rng), to = RandomPose<3>(&rng);
    const double tau = 2.5, kappa = 0.7;
    const GraphEdge<3> edge{0, 1, RandomPose<3>(&rng), IsotropicInformation<3>({tau, kappa}),
                            false};
    const double expected =
        kappa * (to.rotation - from.rotation * edge.measurement.rotation).squaredNorm() +
        tau * (to.translation - from.translation - from.rotation * edge.measurement.translation)
                  .squaredNorm();
    EXPECT_NEAR(2.0 * HalfChi2<3>(from, to, edge, RotationResidual::kHalfSine), expected,
                1e-12 * expected);
  }
}

}  // namespace
}  // namespace planegraph
