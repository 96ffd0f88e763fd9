#pragma once

#include <ceres/sized_cost_function.h>

#include "planegraph/graph/graph.h"
#include "planegraph/graph/manifolds.h"

namespace planegraph {

/// A plane landmark seen by a node, which is a pose (View = PoseView) or a drone map (MapView):
/// what `moments` and `map_moments` have in common; the residual is described there.
template <typename View>
class MomentsCost final : public ceres::SizedCostFunction<3, View::kSize, kPlaneSize> {
 public:
  MomentsCost(const PlaneObservation& seen, const Eigen::Vector3d& anchor)
      : axis_1_(seen.tilt_weight_1 * seen.axes.col(1)),
        axis_2_(seen.tilt_weight_2 * seen.axes.col(2)),
        centroid_(seen.centroid),
        anchor_(anchor),
        offset_weight_(seen.offset_weight) {}

  bool Evaluate(double const* const* blocks, double* residuals, double** jacobians) const override {
    using Eigen::Vector3d;
    const View node(blocks[0]);
    const Vector3d n = Eigen::Map<const Vector3d>(blocks[1]);
    const Vector3d axis_1 = node.rotation * axis_1_, axis_2 = node.rotation * axis_2_;
    const Vector3d turned = node.scale * (node.rotation * centroid_);
    const Vector3d arm = turned + node.t - anchor_;
    residuals[0] = axis_1.dot(n);
    residuals[1] = axis_2.dot(n);
    residuals[2] = offset_weight_ * (n.dot(arm) - blocks[1][3]);
    if (jacobians == nullptr) return true;
    if (jacobians[0] != nullptr) {
      const Vector3d zero = Vector3d::Zero();
      node.SetRow(zero, axis_1.cross(n), 0.0, jacobians[0]);
      node.SetRow(zero, axis_2.cross(n), 0.0, jacobians[0] + View::kSize);
      node.SetRow(offset_weight_ * n, offset_weight_ * turned.cross(n),
                  offset_weight_ * n.dot(turned), jacobians[0] + 2 * View::kSize);
    }
    if (jacobians[1] != nullptr) {
      Eigen::Map<Eigen::Matrix<double, 3, 4, Eigen::RowMajor>> plane(jacobians[1]);
      plane.row(0) << axis_1.transpose(), 0.0;
      plane.row(1) << axis_2.transpose(), 0.0;
      plane.row(2) << offset_weight_ * arm.transpose(), -offset_weight_;
    }
    return true;
  }

 private:
  Eigen::Vector3d axis_1_, axis_2_;  // times their weights
  Eigen::Vector3d centroid_, anchor_;
  double offset_weight_;
};

}  // namespace planegraph
