#pragma once

#include "planegraph/geometry/rotation.h"
#include "planegraph/graph/graph.h"
#include "planegraph/graph/manifolds.h"
#include "planegraph/graph/pose_error.h"

namespace planegraph {

/// r = root [ t - t_m ; Log(R R_m^T) ] of target_from_source = (R, t) against the measurement, with
/// the Jacobians by the blocks of the target and of the source where they are asked for.
inline void EvaluateRelativePose(const Rigid3& measurement, const Matrix6d& root,
                                 double const* const* blocks, double* residuals,
                                 double** jacobians) {
  using Matrix63 = Eigen::Matrix<double, 6, 3>;
  const PoseView target(blocks[0]), source(blocks[1]);
  const Eigen::Quaterniond target_rotation(target.q), source_rotation(source.q);
  const Eigen::Vector3d d = source.t - target.t;
  const Eigen::Matrix3d to_target = target.rotation.transpose();
  const Vector6d error =
      PoseError({target_rotation.conjugate() * source_rotation, to_target * d}, measurement);
  Eigen::Map<Vector6d>(residuals, 6) = root * error;
  if (jacobians == nullptr) return;
  const Matrix63 by_translation = root.leftCols<3>() * to_target;
  const Matrix63 by_rotation =
      root.rightCols<3>() * (InverseLeftJacobian(error.tail<3>()) * to_target);
  if (jacobians[0] != nullptr) {
    WritePoseJacobian(target, -by_translation, by_translation * Hat(d) - by_rotation, jacobians[0]);
  }
  if (jacobians[1] != nullptr) {
    WritePoseJacobian(source, by_translation, by_rotation, jacobians[1]);
  }
}

}  // namespace planegraph
