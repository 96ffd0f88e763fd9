// Absolute prior of a pose (a known start, a position by other means; ALGORITHMS 6.6):
//
//   r = L [ t - t_m ; Log(R R_m^T) ]        L^T L = information
//
// with (R, t) = world_from_node, in the world's axes, metres and radians.
#include <ceres/sized_cost_function.h>

#include "planegraph/graph/factor_registry.h"
#include "planegraph/graph/factor_sampling.h"
#include "planegraph/graph/pose_error.h"

namespace planegraph {
namespace {

class PosePriorCost final : public ceres::SizedCostFunction<6, kPoseSize> {
 public:
  PosePriorCost(const Rigid3& world_from_node, const Matrix6d& information)
      : measurement_(world_from_node), root_(SquareRootInformation(information)) {}

  bool Evaluate(double const* const* blocks, double* residuals, double** jacobians) const override {
    const PoseView pose(blocks[0]);
    const Vector6d error = PoseError({Eigen::Quaterniond(pose.q), pose.t}, measurement_);
    Eigen::Map<Vector6d>(residuals, 6) = root_ * error;
    if (jacobians == nullptr || jacobians[0] == nullptr) return true;
    WritePoseJacobian(pose, root_.leftCols<3>(),
                      root_.rightCols<3>() * InverseLeftJacobian(error.tail<3>()), jacobians[0]);
    return true;
  }

 private:
  Rigid3 measurement_;
  Matrix6d root_;
};

FactorSample Sample(std::mt19937_64* rng) {
  FactorSampler sampler(rng);
  const Rigid3 measurement = sampler.Pose();
  Rigid3 state = sampler.Near(measurement);
  if (sampler.Uniform(0.0, 1.0) < 0.5) {
    state = {(sampler.Rotation() * measurement.rotation).normalized(), sampler.Point()};
  }
  FactorSample sample;
  sample.cost = std::make_unique<PosePriorCost>(measurement, sampler.Information());
  sample.kinds = {BlockKind::kPose};
  sample.values = {FactorSampler::Block(state)};
  return sample;
}

}  // namespace

void Register_pose_prior(FactorRegistry* registry) {
  FactorType type;
  type.name = "pose_prior";
  type.kind = FactorKind::kPose;
  type.description = "absolute prior of one pose";
  type.source =
      "unary factor of pose graphs (Dellaert and Kaess: Factor graphs for robot perception, 2017), "
      "decoupled SO(3) x R^3 error";
  type.residual =
      "translation (m) and rotation vector (rad) of the pose against the prior, world's axes, "
      "whitened";
  type.parameters = {{"measurement", "m, -", "world_from_node", 0.0, true},
                     {"information", "1/m^2, 1/rad^2",
                      "6x6, order x y z rx ry rz, may be rank-deficient", 0.0, true}};
  type.make_cost = [](const PoseFactor& factor) {
    return std::make_unique<PosePriorCost>(factor.measurement, factor.information);
  };
  type.sample = Sample;
  registry->Add(std::move(type));
}

}  // namespace planegraph
