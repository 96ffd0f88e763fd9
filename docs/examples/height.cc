// Height of a point of a scan, by a barometer or by levelling:
//
//   r = w (z . (R a + t) - h)        w = 1 / sigma (1/m)
//
// with (R, t) = world_from_node, a the point in the scan's frame (the lever arm), h its height in
// the world, z the world's vertical axis.
#include <ceres/sized_cost_function.h>

#include <cmath>

#include "planegraph/graph/factor_registry.h"
#include "planegraph/graph/factor_sampling.h"
#include "planegraph/graph/manifolds.h"

namespace planegraph {
namespace {

class HeightCost final : public ceres::SizedCostFunction<1, kPoseSize> {
 public:
  HeightCost(const Eigen::Vector3d& in_node, double height, double weight)
      : in_node_(in_node), height_(height), weight_(weight) {}

  bool Evaluate(double const* const* blocks, double* residuals, double** jacobians) const override {
    const PoseView pose(blocks[0]);
    const Eigen::Vector3d turned = pose.rotation * in_node_;
    residuals[0] = weight_ * (turned.z() + pose.t.z() - height_);
    if (jacobians == nullptr || jacobians[0] == nullptr) return true;
    // A turn dr of the node (world's axes) moves the point by dr x turned.
    const Eigen::Vector3d up = Eigen::Vector3d::UnitZ();
    pose.SetRow(weight_ * up, weight_ * turned.cross(up), jacobians[0]);
    return true;
  }

 private:
  Eigen::Vector3d in_node_;
  double height_, weight_;
};

// A random cost and state: tests and benchmarks know the factor by this alone.
FactorSample Sample(std::mt19937_64* rng) {
  FactorSampler sampler(rng);
  const Eigen::Vector3d in_node = sampler.Point();
  FactorSample sample;
  sample.cost = std::make_unique<HeightCost>(in_node, sampler.Point().z(),
                                             1.0 / sampler.LogUniform(1e-3, 1.0));
  sample.kinds = {BlockKind::kPose};
  sample.values = {FactorSampler::Block(sampler.Pose())};
  return sample;
}

}  // namespace

void Register_height(FactorRegistry* registry) {
  FactorType type;
  type.name = "height";
  type.kind = FactorKind::kPose;
  type.description = "height of a point of a scan, by a barometer or by levelling";
  type.source = "own derivation";
  type.residual = "height of the point less the measured one (m), whitened";
  type.parameters = {{"point", "m", "the point in the scan's frame", 0.0, true},
                     {"measurement", "m", "the z of its translation: the height", 0.0, true},
                     {"information", "1/m^2", "its third diagonal element, of z", 0.0, true}};
  type.make_cost = [](const PoseFactor& factor) {
    return std::make_unique<HeightCost>(factor.point, factor.measurement.translation.z(),
                                        std::sqrt(factor.information(2, 2)));
  };
  type.sample = Sample;
  registry->Add(std::move(type));
}

}  // namespace planegraph
