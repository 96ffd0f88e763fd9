// Relative pose of two nodes (registration, odometry; ALGORITHMS 6.6) in the convention of the
// project's covariances: with target_from_source = (R, t) of the estimate and (R_m, t_m) of the
// measurement,
//
//   r = L [ t - t_m ; Log(R R_m^T) ]        L^T L = information
//
// in the target's axes, metres and radians. A rank-deficient information leaves its null directions
// free.
#include <ceres/sized_cost_function.h>

#include "factors/relative_pose_terms.h"
#include "planegraph/graph/factor_registry.h"
#include "planegraph/graph/factor_sampling.h"

namespace planegraph {
namespace {

class RelativePoseCost final : public ceres::SizedCostFunction<6, kPoseSize, kPoseSize> {
 public:
  RelativePoseCost(const Rigid3& target_from_source, const Matrix6d& information)
      : measurement_(target_from_source), root_(SquareRootInformation(information)) {}

  bool Evaluate(double const* const* blocks, double* residuals, double** jacobians) const override {
    EvaluateRelativePose(measurement_, root_, blocks, residuals, jacobians);
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
  sample.cost = std::make_unique<RelativePoseCost>(target_from_source, sampler.Information());
  sample.kinds = {BlockKind::kPose, BlockKind::kPose};
  // Any error half of the time (its rotation may be near pi), a small one otherwise.
  const Rigid3 source =
      sampler.Uniform(0.0, 1.0) < 0.5
          ? Rigid3(
                (target.rotation * sampler.Rotation() * target_from_source.rotation).normalized(),
                sampler.Point())
          : sampler.Near(target * target_from_source);
  sample.values = {FactorSampler::Block(target), FactorSampler::Block(source)};
  return sample;
}

}  // namespace

void Register_relative_pose(FactorRegistry* registry) {
  FactorType type;
  type.name = "relative_pose";
  type.kind = FactorKind::kPose;
  type.description = "relative pose of two nodes, by registration or odometry";
  type.source =
      "Lu and Milios: Globally consistent range scan alignment, 1997; decoupled SO(3) x R^3 error";
  type.residual =
      "translation (m) and rotation vector (rad) of the estimate against the measurement, target's "
      "axes, "
      "whitened";
  type.parameters = {
      {"measurement", "m, -", "target_from_source of poses (target, source)", 0.0, true},
      {"information", "1/m^2, 1/rad^2", "6x6, order x y z rx ry rz, may be rank-deficient", 0.0,
       true}};
  type.make_cost = [](const PoseFactor& factor) {
    return std::make_unique<RelativePoseCost>(factor.measurement, factor.information);
  };
  type.sample = Sample;
  registry->Add(std::move(type));
}

}  // namespace planegraph
