// A step of odometry whose metre is not quite one (wheels, tracks and visual odometry err by a
// factor that stays the same over a run): the relative pose of two nodes, with target_from_source =
// (R, t) of the estimate, (R_m, t_m) of the measurement, and the scale s that all steps share,
//
//   r = L [ t - s t_m ; Log(R R_m^T) ]        L^T L = information
//
// in the target's axes, metres and radians. The information is that of what each step errs by on
// its own; the scale has a prior (`scale_prior`).
#include <ceres/sized_cost_function.h>

#include "factors/relative_pose_terms.h"
#include "planegraph/graph/factor_registry.h"
#include "planegraph/graph/factor_sampling.h"

namespace planegraph {
namespace {

class OdometryStepCost final : public ceres::SizedCostFunction<6, kPoseSize, kPoseSize, 1> {
 public:
  OdometryStepCost(const Rigid3& target_from_source, const Matrix6d& information)
      : measurement_(target_from_source), root_(SquareRootInformation(information)) {}

  bool Evaluate(double const* const* blocks, double* residuals, double** jacobians) const override {
    const Rigid3 scaled{measurement_.rotation, blocks[2][0] * measurement_.translation};
    EvaluateRelativePose(scaled, root_, blocks, residuals, jacobians);
    if (jacobians != nullptr && jacobians[2] != nullptr) {
      Eigen::Map<Vector6d>(jacobians[2], 6) = -root_.leftCols<3>() * measurement_.translation;
    }
    return true;
  }

 private:
  Rigid3 measurement_;
  Matrix6d root_;
};

FactorSample Sample(std::mt19937_64* rng) {
  FactorSampler sampler(rng);
  const Rigid3 target = sampler.Pose(), target_from_source = sampler.Pose();
  FactorSample sample;
  sample.cost = std::make_unique<OdometryStepCost>(target_from_source, sampler.Information());
  sample.kinds = {BlockKind::kPose, BlockKind::kPose, BlockKind::kScale};
  const Rigid3 source = sampler.Near(target * target_from_source);
  sample.values = {
      FactorSampler::Block(target), FactorSampler::Block(source), {sampler.Uniform(0.5, 2.0)}};
  return sample;
}

}  // namespace

void Register_odometry_step(FactorRegistry* registry) {
  FactorType type;
  type.name = "odometry_step";
  type.kind = FactorKind::kPose;
  type.description = "relative pose of two nodes by odometry, its scale an unknown of the robot";
  type.source =
      "systematic and random errors of odometry apart: Borenstein and Feng, 1996; own derivation";
  type.residual =
      "translation (m) against the scaled measurement, rotation vector (rad), target's axes, "
      "whitened";
  type.parameters = {{"measurement", "m, -", "target_from_source", 0.0, true},
                     {"information", "1/m^2, 1/rad^2",
                      "6x6, of the step's own errors, order x y z rx ry rz", 0.0, true}};
  type.make_cost = [](const PoseFactor& factor) {
    return std::make_unique<OdometryStepCost>(factor.measurement, factor.information);
  };
  type.sample = Sample;
  registry->Add(std::move(type));
}

}  // namespace planegraph
