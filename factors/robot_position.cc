// Position of a robot's antenna by GPS, or by other means (ALGORITHMS 6.6):
//
//   r = L (R a + t - p)        L^T L = information (3x3, 1/m^2, world's axes)
//
// with (R, t) = world_from_node, a the antenna in the scan's frame (the lever arm), p its position
// in the world.
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

class RobotPositionCost final : public ceres::SizedCostFunction<3, kPoseSize> {
 public:
  explicit RobotPositionCost(const PoseFactor& factor)
      : antenna_(factor.point),
        position_(factor.measurement.translation),
        root_(SquareRoot(factor.information.topLeftCorner<3, 3>())) {}

  bool Evaluate(double const* const* blocks, double* residuals, double** jacobians) const override {
    const PoseView pose(blocks[0]);
    const Vector3d turned = pose.rotation * antenna_;
    Eigen::Map<Vector3d>(residuals, 3) = root_ * (turned + pose.t - position_);
    if (jacobians == nullptr || jacobians[0] == nullptr) return true;
    const Matrix3d by_rotation = -root_ * Hat(turned);
    for (int k = 0; k < 3; ++k) {
      pose.SetRow(root_.row(k), by_rotation.row(k), jacobians[0] + 7 * k);
    }
    return true;
  }

 private:
  Vector3d antenna_, position_;
  Matrix3d root_;
};

FactorSample Sample(std::mt19937_64* rng) {
  FactorSampler sampler(rng);
  PoseFactor factor;
  factor.point = sampler.Point();
  factor.measurement.translation = sampler.Point();
  factor.information = sampler.Information() + Matrix6d::Identity();
  FactorSample sample;
  sample.cost = std::make_unique<RobotPositionCost>(factor);
  sample.kinds = {BlockKind::kPose};
  sample.values = {FactorSampler::Block(sampler.Pose())};
  return sample;
}

}  // namespace

void Register_robot_position(FactorRegistry* registry) {
  FactorType type;
  type.name = "robot_position";
  type.kind = FactorKind::kPose;
  type.description = "position of a robot's antenna, by GPS";
  type.residual = "antenna less its measured position (m, world's axes), whitened";
  type.parameters = {{"point", "m", "the antenna in the scan's frame", 0.0, true},
                     {"measurement", "m", "its translation: where it was, world", 0.0, true},
                     {"information", "1/m^2", "upper left 3x3, world's axes", 0.0, true}};
  type.make_cost = [](const PoseFactor& factor) {
    return std::make_unique<RobotPositionCost>(factor);
  };
  type.sample = Sample;
  registry->Add(std::move(type));
}

}  // namespace planegraph
