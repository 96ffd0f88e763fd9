#include "planegraph/graph/plane_charts.h"

#include <Eigen/Geometry>
#include <cmath>

namespace planegraph {
namespace {

using Eigen::Map;
using Eigen::Matrix3d;
using Eigen::Vector3d;
using Eigen::Vector4d;
using PlusMatrix = Eigen::Matrix<double, 4, 3, Eigen::RowMajor>;
using MinusMatrix = Eigen::Matrix<double, 3, 4, Eigen::RowMajor>;

constexpr double kLeastDistance = 1e-6;  // metres

}  // namespace

double ClosestPointManifold::Distance(const double* x) const {
  const double d = x[3] + Map<const Vector3d>(x).dot(arm_);
  return std::copysign(std::max(std::abs(d), kLeastDistance), d);
}

bool ClosestPointManifold::Plus(const double* x, const double* delta, double* out) const {
  const double d = Distance(x);
  const Vector3d closest = d * Map<const Vector3d>(x) + Map<const Vector3d>(delta);
  const double length = closest.norm();
  if (!(length > 0.0)) return false;
  // The normal keeps its side: only a step through the origin turns it.
  const Vector3d n = std::copysign(1.0 / length, d) * closest;
  Map<Vector3d>(out, 3) = n;
  out[3] = std::copysign(length, d) - n.dot(arm_);
  return true;
}

bool ClosestPointManifold::PlusJacobian(const double* x, double* jacobian) const {
  const Vector3d n = Map<const Vector3d>(x);
  Map<PlusMatrix> j(jacobian);
  j.topRows<3>() = (Matrix3d::Identity() - n * n.transpose()) / Distance(x);
  j.row(3) = n.transpose() - arm_.transpose() * j.topRows<3>();
  return true;
}

bool ClosestPointManifold::Minus(const double* y, const double* x, double* y_minus_x) const {
  Map<Vector3d>(y_minus_x, 3) =
      Distance(y) * Map<const Vector3d>(y) - Distance(x) * Map<const Vector3d>(x);
  return true;
}

bool ClosestPointManifold::MinusJacobian(const double* x, double* jacobian) const {
  // d(CP) with CP = d n and d = e + n . arm.
  const Vector3d n = Map<const Vector3d>(x);
  Map<MinusMatrix> j(jacobian);
  j << n * arm_.transpose() + Distance(x) * Matrix3d::Identity(), n;
  return true;
}

Vector4d MultiplyQuaternions(const Vector4d& a, const Vector4d& b) {
  Vector4d product;
  product << a[3] * b.head<3>() + b[3] * a.head<3>() + a.head<3>().cross(b.head<3>()),
      a[3] * b[3] - a.head<3>().dot(b.head<3>());
  return product;
}

Vector4d ConjugateQuaternion(const Vector4d& q) { return {-q[0], -q[1], -q[2], q[3]}; }

Vector3d HalfAngleLog(Vector4d q) {
  if (q[3] < 0.0) q = -q;
  const double sine = q.head<3>().norm();
  return (sine > 1e-6 ? std::atan2(sine, q[3]) / sine : 1.0 + sine * sine / 6.0) * q.head<3>();
}

Eigen::Matrix<double, 3, 4> HalfAngleLogJacobian(const Vector4d& q) {
  const double sign = q[3] < 0.0 ? -1.0 : 1.0;
  const Vector3d v = sign * q.head<3>();
  const double w = sign * q[3], square = v.squaredNorm(), sine = std::sqrt(square);
  const double ratio = sine > 1e-6 ? std::atan2(sine, w) / sine : 1.0 + square / 6.0;
  const double bend = sine > 1e-3 ? (w - ratio) / square : -2.0 / 3.0 - square / 5.0;
  Eigen::Matrix<double, 3, 4> jacobian;
  jacobian << ratio * Matrix3d::Identity() + bend * v * v.transpose(), -v;
  return sign * jacobian;
}

Vector4d UnitQuaternionManifold::ToQuaternion(const double* x) const {
  const Vector3d n = Map<const Vector3d>(x);
  return Vector4d(n.x(), n.y(), n.z(), x[3] / unit_).normalized();
}

bool UnitQuaternionManifold::Plus(const double* x, const double* delta, double* out) const {
  const Map<const Vector3d> d(delta);
  const double angle = d.norm();
  const Vector3d v = (angle > 1e-6 ? std::sin(angle) / angle : 1.0 - angle * angle / 6.0) * d;
  const Vector4d q =
      MultiplyQuaternions(ToQuaternion(x), Vector4d(v.x(), v.y(), v.z(), std::cos(angle)));
  const double length = q.head<3>().norm();
  if (!(length > 1e-12)) return false;
  const Vector3d n = q.head<3>() / length;
  Map<Vector3d>(out, 3) = n;
  out[3] = unit_ * q[3] / length;
  return true;
}

bool UnitQuaternionManifold::PlusJacobian(const double* x, double* jacobian) const {
  const Vector3d n = Map<const Vector3d>(x);
  const Vector4d q = ToQuaternion(x);
  const double length = q.head<3>().norm(), ratio = q[3] / length;
  Map<PlusMatrix> j(jacobian);
  for (int k = 0; k < 3; ++k) {
    const Vector4d moved = MultiplyQuaternions(q, Vector4d::Unit(k)) / length;
    const Vector3d dn = moved.head<3>() - n * n.dot(moved.head<3>());
    j.col(k) << dn, unit_ * (moved[3] - ratio * n.dot(moved.head<3>()));
  }
  return true;
}

bool UnitQuaternionManifold::Minus(const double* y, const double* x, double* y_minus_x) const {
  Map<Vector3d>(y_minus_x, 3) =
      HalfAngleLog(MultiplyQuaternions(ConjugateQuaternion(ToQuaternion(x)), ToQuaternion(y)));
  return true;
}

bool UnitQuaternionManifold::MinusJacobian(const double* x, double* jacobian) const {
  const Vector4d q = ToQuaternion(x);
  const double length = q.head<3>().norm();  // 1 / |(n, e / u)|
  Map<MinusMatrix> j(jacobian);
  for (int k = 0; k < 4; ++k) {
    const Vector4d raw = (k < 3 ? 1.0 : 1.0 / unit_) * Vector4d::Unit(k);
    const Vector4d dq = length * (raw - q * q.dot(raw));
    j.col(k) = MultiplyQuaternions(ConjugateQuaternion(q), dq).head<3>();
  }
  return true;
}

}  // namespace planegraph
