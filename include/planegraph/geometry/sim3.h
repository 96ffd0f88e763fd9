#pragma once

#include "planegraph/geometry/rigid3.h"

namespace planegraph {

/// 7x7 in the order x y z rx ry rz log(scale): decoupled left perturbation R <- Exp(r) R, t <- t +
/// x in the target's axes, s <- s exp(l); metres and radians.
using Matrix7d = Eigen::Matrix<double, 7, 7>;
using Vector7d = Eigen::Matrix<double, 7, 1>;

/// A similarity named `target_from_source`: x_target = scale * rotation * x_source + translation.
struct Sim3 {
  double scale = 1.0;
  Eigen::Quaterniond rotation = Eigen::Quaterniond::Identity();
  Eigen::Vector3d translation = Eigen::Vector3d::Zero();

  Sim3() = default;
  Sim3(double s, const Eigen::Quaterniond& r, const Eigen::Vector3d& t)
      : scale(s), rotation(r), translation(t) {}
  explicit Sim3(const Rigid3& rigid) : rotation(rigid.rotation), translation(rigid.translation) {}

  Sim3 Inverse() const {
    const Eigen::Quaterniond inverse = rotation.conjugate();
    return {1.0 / scale, inverse, -(inverse * translation) / scale};
  }
  Eigen::Vector3d operator*(const Eigen::Vector3d& point) const {
    return scale * (rotation * point) + translation;
  }
  Sim3 operator*(const Sim3& other) const {
    return {scale * other.scale, (rotation * other.rotation).normalized(),
            scale * (rotation * other.translation) + translation};
  }
};

}  // namespace planegraph
