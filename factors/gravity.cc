// Gravity seen from a scan: ties its tilt to the world's (ALGORITHMS 6.6).
//
//   r = L (R u - z)        L^T L = information (3x3, 1/rad^2, world's axes)
//
// with R the rotation of world_from_node, u the direction upwards in the scan's frame, z that
// in the world (unit vectors). Small tilts are radians; the heading is free.
#include <ceres/sized_cost_function.h>

#include "factors/square_root.h"
#include "planegraph/geometry/rotation.h"
#include "planegraph/graph/factor_registry.h"
#include "planegraph/graph/factor_sampling.h"
#include "planegraph/graph/manifolds.h"

namespace planegraph {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

class GravityCost final : public ceres::SizedCostFunction<3, kPoseSize> {
 public:
  explicit GravityCost(const PoseFactor& factor)
      : up_(factor.point),
        up_in_world_(factor.measurement.translation),
        root_(SquareRoot(factor.information.block<3, 3>(3, 3))) {}

  bool Evaluate(double const* const* blocks, double* residuals, double** jacobians) const override {
    const PoseView node(blocks[0]);
    const Vector3d turned = node.rotation * up_;
    Eigen::Map<Vector3d>(residuals, 3) = root_ * (turned - up_in_world_);
    if (jacobians == nullptr || jacobians[0] == nullptr) return true;
    const Matrix3d by_rotation = -root_ * Hat(turned);
    const Vector3d zero = Vector3d::Zero();
    for (int k = 0; k < 3; ++k) {
      node.SetRow(zero, by_rotation.row(k), jacobians[0] + 7 * k);
    }
    return true;
  }

 private:
  Vector3d up_, up_in_world_;
  Matrix3d root_;
};

FactorSample Sample(std::mt19937_64* rng) {
  FactorSampler sampler(rng);
  PoseFactor factor;
  factor.point = sampler.UnitVector();
  factor.measurement.translation = sampler.UnitVector();
  factor.information.block<3, 3>(3, 3) =
      sampler.Information().topLeftCorner<3, 3>() + Matrix3d::Identity();
  FactorSample sample;
  sample.cost = std::make_unique<GravityCost>(factor);
  sample.kinds = {BlockKind::kPose};
  sample.values = {FactorSampler::Block(sampler.Pose())};
  return sample;
}

}  // namespace

void Register_gravity(FactorRegistry* registry) {
  FactorType type;
  type.name = "gravity";
  type.kind = FactorKind::kPose;
  type.description = "gravity as a scan sees it: ties the tilt to the world's vertical";
  type.residual = "scan's direction upwards less the world's (rad, world's axes), whitened";
  type.parameters = {
      {"point", "-", "unit vector upwards in the scan's frame", 0.0, true},
      {"measurement", "-", "its translation: unit vector upwards in the world", 0.0, true},
      {"information", "1/rad^2", "3x3 of the rotation, world's axes", 0.0, true}};
  type.make_cost = [](const PoseFactor& factor) { return std::make_unique<GravityCost>(factor); };
  type.sample = Sample;
  registry->Add(std::move(type));
}

}  // namespace planegraph
