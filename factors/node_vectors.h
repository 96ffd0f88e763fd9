#pragma once

#include <ceres/sized_cost_function.h>

#include "factors/square_root.h"
#include "planegraph/geometry/rotation.h"
#include "planegraph/graph/factor_registry.h"
#include "planegraph/graph/factor_sampling.h"
#include "planegraph/graph/manifolds.h"

namespace planegraph {

/// A point of a node (View = PoseView or MapView) that is known in the world: r = L (s R a + t -
/// p), L^T L = information (1/m^2, world's axes), (s, R, t) = world_from_node, s = 1 for a pose.
template <typename View>
class PositionCost final : public ceres::SizedCostFunction<3, View::kSize> {
 public:
  PositionCost(const Eigen::Vector3d& in_node, const Eigen::Vector3d& in_world,
               const Eigen::Matrix3d& information)
      : in_node_(in_node), in_world_(in_world), root_(SquareRoot(information)) {}

  bool Evaluate(double const* const* blocks, double* residuals, double** jacobians) const override {
    const View node(blocks[0]);
    const Eigen::Vector3d turned = node.scale * (node.rotation * in_node_);
    Eigen::Map<Eigen::Vector3d>(residuals, 3) = root_ * (turned + node.t - in_world_);
    if (jacobians == nullptr || jacobians[0] == nullptr) return true;
    const Eigen::Matrix3d by_rotation = -root_ * Hat(turned);
    const Eigen::Vector3d by_scale = root_ * turned;
    for (int k = 0; k < 3; ++k) {
      node.SetRow(root_.row(k), by_rotation.row(k), by_scale[k], jacobians[0] + View::kSize * k);
    }
    return true;
  }

 private:
  Eigen::Vector3d in_node_, in_world_;
  Eigen::Matrix3d root_;
};

/// A direction of a node that is known in the world: r = L (R u - z), u and z unit vectors, L^T L =
/// information (1/rad^2, world's axes). Small angles are radians; the turn about z is free.
template <typename View>
class DirectionCost final : public ceres::SizedCostFunction<3, View::kSize> {
 public:
  DirectionCost(const Eigen::Vector3d& in_node, const Eigen::Vector3d& in_world,
                const Eigen::Matrix3d& information)
      : in_node_(in_node), in_world_(in_world), root_(SquareRoot(information)) {}

  bool Evaluate(double const* const* blocks, double* residuals, double** jacobians) const override {
    const View node(blocks[0]);
    const Eigen::Vector3d turned = node.rotation * in_node_;
    Eigen::Map<Eigen::Vector3d>(residuals, 3) = root_ * (turned - in_world_);
    if (jacobians == nullptr || jacobians[0] == nullptr) return true;
    const Eigen::Matrix3d by_rotation = -root_ * Hat(turned);
    const Eigen::Vector3d zero = Eigen::Vector3d::Zero();
    for (int k = 0; k < 3; ++k) {
      node.SetRow(zero, by_rotation.row(k), 0.0, jacobians[0] + View::kSize * k);
    }
    return true;
  }

 private:
  Eigen::Vector3d in_node_, in_world_;
  Eigen::Matrix3d root_;
};

/// A cost with one node at a random state.
template <typename View>
FactorSample NodeSample(std::unique_ptr<ceres::CostFunction> cost, FactorSampler* sampler) {
  constexpr bool kIsMap = View::kSize == kMapSize;
  FactorSample sample;
  sample.cost = std::move(cost);
  sample.kinds = {kIsMap ? BlockKind::kMap : BlockKind::kPose};
  sample.values = {kIsMap ? FactorSampler::Block(sampler->Map())
                          : FactorSampler::Block(sampler->Pose())};
  return sample;
}

/// A 3x3 information of full rank.
inline Eigen::Matrix3d SampleInformation3(FactorSampler* sampler) {
  return sampler->Information().topLeftCorner<3, 3>() + Eigen::Matrix3d::Identity();
}

}  // namespace planegraph
