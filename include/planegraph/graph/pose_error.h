#pragma once

#include "planegraph/graph/graph.h"
#include "planegraph/graph/manifolds.h"

namespace planegraph {

/// Inverse left Jacobian of SO(3): Log(Exp(d) Exp(phi)) = phi + J_l^{-1}(phi) d + O(d^2); |phi| < 2
/// pi.
Eigen::Matrix3d InverseLeftJacobian(const Eigen::Vector3d& phi);

/// Estimate minus measurement in the convention of all covariances: (t - t_m, Log(R R_m^T)), in the
/// target's axes, metres and radians.
Vector6d PoseError(const Rigid3& estimate, const Rigid3& measurement);

/// Writes whitening * [by_translation, by_rotation] (6x3 each) as the ambient Jacobian of a pose
/// block.
void WritePoseJacobian(const PoseView& pose, const Eigen::Matrix<double, 6, 3>& by_translation,
                       const Eigen::Matrix<double, 6, 3>& by_rotation, double* jacobian);

}  // namespace planegraph
