#include "planegraph/graph/pose_error.h"

#include <cmath>

#include "planegraph/geometry/rotation.h"

namespace planegraph {

Eigen::Matrix3d InverseLeftJacobian(const Eigen::Vector3d& phi) {
  const double angle = phi.norm(), half = 0.5 * angle;
  // (1 - x cot x) / (2 x)^2 with x = angle / 2, by its series near zero.
  const double factor = angle > 1e-3
                            ? (1.0 - half * std::cos(half) / std::sin(half)) / (angle * angle)
                            : 1.0 / 12.0 + angle * angle / 720.0;
  const Eigen::Matrix3d hat = Hat(phi);
  return Eigen::Matrix3d::Identity() - 0.5 * hat + factor * hat * hat;
}

Vector6d PoseError(const Rigid3& estimate, const Rigid3& measurement) {
  Vector6d error;
  error << estimate.translation - measurement.translation,
      LogSO3(estimate.rotation * measurement.rotation.conjugate());
  return error;
}

void WritePoseJacobian(const PoseView& pose, const Eigen::Matrix<double, 6, 3>& by_translation,
                       const Eigen::Matrix<double, 6, 3>& by_rotation, double* jacobian) {
  for (int row = 0; row < 6; ++row) {
    pose.SetRow(by_translation.row(row), by_rotation.row(row), jacobian + kPoseSize * row);
  }
}

}  // namespace planegraph
