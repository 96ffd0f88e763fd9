// The example of docs/new_factor.md, as the generic tests would take it up in factors/.
#include <gtest/gtest.h>

#include <Eigen/Core>

#include "planegraph/graph/factor_registry.h"
#include "planegraph/graph/manifolds.h"

namespace planegraph {

void Register_height(FactorRegistry* registry);

namespace {

const FactorType& Height() {
  static const FactorRegistry* registry = [] {
    auto* made = new FactorRegistry;
    Register_height(made);
    return made;
  }();
  return registry->Get("height", FactorKind::kPose);
}

double Residual(const ceres::CostFunction& cost, const double* pose) {
  double residual = 0.0;
  EXPECT_TRUE(cost.Evaluate(&pose, &residual, nullptr));
  return residual;
}

TEST(HeightExample, SaysWhatItIs) {
  EXPECT_FALSE(Height().description.empty());
  EXPECT_FALSE(Height().residual.empty());
  EXPECT_FALSE(Height().source.empty());
}

TEST(HeightExample, IsTheHeightInSigmas) {
  PoseFactor factor;
  factor.type = "height";
  factor.poses = {0};
  factor.point = {0.0, 0.0, 0.5};
  factor.measurement.translation.z() = 2.0;
  factor.information(2, 2) = 1.0 / (0.1 * 0.1);
  const auto cost = Height().make_cost(factor);
  double block[kPoseSize];
  PoseToBlock({Eigen::Quaterniond::Identity(), {7.0, 8.0, 1.8}}, block);
  EXPECT_NEAR(Residual(*cost, block), 3.0, 1e-12) << "0.3 m too high, sigma 0.1 m";
}

TEST(HeightExample, JacobiansAreTheDerivatives) {
  std::mt19937_64 rng(7);
  const Se3Manifold manifold;
  for (int trial = 0; trial < 500; ++trial) {
    const FactorSample sample = Height().sample(&rng);
    const double* block = sample.values[0].data();
    double residual = 0.0;
    Eigen::Matrix<double, 1, kPoseSize> ambient;
    double* jacobian = ambient.data();
    ASSERT_TRUE(sample.cost->Evaluate(&block, &residual, &jacobian));
    Eigen::Matrix<double, kPoseSize, kPoseTangent, Eigen::RowMajor> plus;
    manifold.PlusJacobian(block, plus.data());
    const Eigen::RowVectorXd tangent = ambient * plus;
    for (int k = 0; k < kPoseTangent; ++k) {
      const double step = 1e-5;
      const auto moved = [&](double by) {
        const Eigen::VectorXd delta = by * Eigen::VectorXd::Unit(kPoseTangent, k);
        double at[kPoseSize];
        manifold.Plus(block, delta.data(), at);
        return Residual(*sample.cost, at);
      };
      const double numeric = (moved(step) - moved(-step)) / (2.0 * step);
      const double rounding = 1e-15 * std::abs(residual) / step;
      EXPECT_NEAR(tangent[k], numeric, 1e-6 * (1.0 + tangent.norm()) + 100.0 * rounding);
    }
  }
}

}  // namespace
}  // namespace planegraph
