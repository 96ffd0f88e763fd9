#include "planegraph/geometry/rotation.h"

#include <Eigen/SVD>
#include <cmath>

namespace planegraph {

Eigen::Matrix3d Hat(const Eigen::Vector3d& a) {
  Eigen::Matrix3d m;
  m << 0, -a.z(), a.y(), a.z(), 0, -a.x(), -a.y(), a.x(), 0;
  return m;
}

Eigen::Quaterniond ExpSO3(const Eigen::Vector3d& rotation_vector) {
  const double angle = rotation_vector.norm();
  const double half = 0.5 * angle;
  // sin(a/2)/a by its series where the division would lose digits.
  const double factor = angle > 1e-6 ? std::sin(half) / angle : 0.5 - angle * angle / 48.0;
  const Eigen::Vector3d v = factor * rotation_vector;
  return Eigen::Quaterniond(std::cos(half), v.x(), v.y(), v.z()).normalized();
}

Eigen::Vector3d LogSO3(const Eigen::Quaterniond& rotation) {
  // q and -q are the same rotation; the one with w >= 0 has the shorter angle.
  const double sign = rotation.w() < 0 ? -1.0 : 1.0;
  const Eigen::Vector3d v = sign * rotation.vec();
  const double w = sign * rotation.w();
  const double sine = v.norm();
  if (sine < 1e-9) return 2.0 * v / w;
  return 2.0 * std::atan2(sine, w) / sine * v;
}

double AngleBetween(const Eigen::Quaterniond& a, const Eigen::Quaterniond& b) {
  return LogSO3(a.conjugate() * b).norm();
}

Eigen::Matrix<double, 3, 2> TangentBasis(const Eigen::Vector3d& normal) {
  // Duff et al. 2017, "Building an orthonormal basis, revisited": no branch but the sign of z.
  const double sign = std::copysign(1.0, normal.z());
  const double a = -1.0 / (sign + normal.z());
  const double b = normal.x() * normal.y() * a;
  Eigen::Matrix<double, 3, 2> basis;
  basis.col(0) << 1.0 + sign * normal.x() * normal.x() * a, sign * b, -sign * normal.x();
  basis.col(1) << b, sign + normal.y() * normal.y() * a, -normal.y();
  return basis;
}

Eigen::Matrix3d ProjectToRotation(const Eigen::Matrix3d& matrix) {
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(matrix, Eigen::ComputeFullU | Eigen::ComputeFullV);
  const double determinant = (svd.matrixU() * svd.matrixV().transpose()).determinant();
  const Eigen::Vector3d signs(1.0, 1.0, determinant < 0 ? -1.0 : 1.0);
  return svd.matrixU() * signs.asDiagonal() * svd.matrixV().transpose();
}

}  // namespace planegraph
