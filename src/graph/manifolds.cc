#include "planegraph/graph/manifolds.h"

#include <cmath>

#include "planegraph/geometry/rotation.h"

namespace planegraph {
namespace {

using Eigen::Map;
using Eigen::Quaterniond;
using Eigen::Vector3d;
template <int R, int C>
using RowMajor = Eigen::Matrix<double, R, C, Eigen::RowMajor>;

}  // namespace

bool Se3Manifold::Plus(const double* x, const double* delta, double* x_plus_delta) const {
  const Quaterniond moved =
      ExpSO3(Vector3d(Map<const Vector3d>(delta + 3))) * Quaterniond(Map<const Quaterniond>(x));
  Map<Eigen::Vector4d>(x_plus_delta, 4) = moved.normalized().coeffs();
  Map<Vector3d>(x_plus_delta + 4) = Map<const Vector3d>(x + 4) + Map<const Vector3d>(delta);
  return true;
}

bool Se3Manifold::PlusJacobian(const double* x, double* jacobian) const {
  // d(Exp(r) q) = (r/2, 0) q, whose vector part is (w r + r x v) / 2 and whose scalar part -r.v
  // / 2.
  Map<RowMajor<7, 6>> j(jacobian);
  const Vector3d v(x[0], x[1], x[2]);
  j.setZero();
  j.block<3, 3>(0, 3) = 0.5 * (x[3] * Eigen::Matrix3d::Identity() - Hat(v));
  j.block<1, 3>(3, 3) = -0.5 * v.transpose();
  j.block<3, 3>(4, 0).setIdentity();
  return true;
}

bool Se3Manifold::Minus(const double* y, const double* x, double* y_minus_x) const {
  const Quaterniond qx{Map<const Quaterniond>(x)}, qy{Map<const Quaterniond>(y)};
  Map<Vector3d>(y_minus_x + 3) = LogSO3(qy * qx.conjugate());
  Map<Vector3d>(y_minus_x, 3) = Map<const Vector3d>(y + 4) - Map<const Vector3d>(x + 4);
  return true;
}

bool Se3Manifold::MinusJacobian(const double* x, double* jacobian) const {
  Map<RowMajor<6, 7>> j(jacobian);
  const Vector3d v(x[0], x[1], x[2]);
  j.setZero();
  j.block<3, 3>(3, 0) = 2.0 * (x[3] * Eigen::Matrix3d::Identity() + Hat(v));
  j.block<3, 1>(3, 3) = -2.0 * v;
  j.block<3, 3>(0, 4).setIdentity();
  return true;
}

bool UnitVectorManifold::Plus(const double* x, const double* delta, double* x_plus_delta) const {
  const Vector3d n = Map<const Vector3d>(x);
  const Map<const Eigen::Vector2d> d(delta);
  const double angle = d.norm();
  const double sinc = angle > 1e-6 ? std::sin(angle) / angle : 1.0 - angle * angle / 6.0;
  Map<Vector3d>(x_plus_delta, 3) =
      (std::cos(angle) * n + sinc * (TangentBasis(n) * d)).normalized();
  return true;
}

bool UnitVectorManifold::PlusJacobian(const double* x, double* jacobian) const {
  Map<RowMajor<3, 2>> j(jacobian);
  j = TangentBasis(Vector3d(Map<const Vector3d>(x)));
  return true;
}

bool UnitVectorManifold::Minus(const double* y, const double* x, double* y_minus_x) const {
  const Vector3d n = Map<const Vector3d>(x), m = Map<const Vector3d>(y);
  const Eigen::Vector2d tangent = TangentBasis(n).transpose() * m;
  const double sine = tangent.norm(), cosine = n.dot(m);
  Map<Eigen::Vector2d> out(y_minus_x);
  if (sine > 1e-9) {
    out = std::atan2(sine, cosine) / sine * tangent;
  } else if (cosine > 0.0) {
    out = tangent / cosine;
  } else {
    out << EIGEN_PI, 0.0;  // the antipode: every direction leads there
  }
  return true;
}

bool UnitVectorManifold::MinusJacobian(const double* x, double* jacobian) const {
  Map<RowMajor<2, 3>> j(jacobian);
  j = TangentBasis(Vector3d(Map<const Vector3d>(x))).transpose();
  return true;
}

bool PlaneManifold::Plus(const double* x, const double* delta, double* x_plus_delta) const {
  x_plus_delta[3] = x[3] + delta[2];
  return normal_.Plus(x, delta, x_plus_delta);
}

bool PlaneManifold::PlusJacobian(const double* x, double* jacobian) const {
  Map<RowMajor<4, 3>> j(jacobian);
  j.setZero();
  j.block<3, 2>(0, 0) = TangentBasis(Vector3d(Map<const Vector3d>(x)));
  j(3, 2) = 1.0;
  return true;
}

bool PlaneManifold::Minus(const double* y, const double* x, double* y_minus_x) const {
  y_minus_x[2] = y[3] - x[3];
  return normal_.Minus(y, x, y_minus_x);
}

bool PlaneManifold::MinusJacobian(const double* x, double* jacobian) const {
  Map<RowMajor<3, 4>> j(jacobian);
  j.setZero();
  j.block<2, 3>(0, 0) = TangentBasis(Vector3d(Map<const Vector3d>(x))).transpose();
  j(2, 3) = 1.0;
  return true;
}

bool Sim3Manifold::Plus(const double* x, const double* delta, double* x_plus_delta) const {
  rigid_.Plus(x, delta, x_plus_delta);
  x_plus_delta[7] = x[7] + delta[6];
  return true;
}

bool Sim3Manifold::PlusJacobian(const double* x, double* jacobian) const {
  RowMajor<7, 6> rigid;
  rigid_.PlusJacobian(x, rigid.data());
  Map<RowMajor<8, 7>> j(jacobian);
  j.setZero();
  j.topLeftCorner<7, 6>() = rigid;
  j(7, 6) = 1.0;
  return true;
}

bool Sim3Manifold::Minus(const double* y, const double* x, double* y_minus_x) const {
  rigid_.Minus(y, x, y_minus_x);
  y_minus_x[6] = y[7] - x[7];
  return true;
}

bool Sim3Manifold::MinusJacobian(const double* x, double* jacobian) const {
  RowMajor<6, 7> rigid;
  rigid_.MinusJacobian(x, rigid.data());
  Map<RowMajor<7, 8>> j(jacobian);
  j.setZero();
  j.topLeftCorner<6, 7>() = rigid;
  j(6, 7) = 1.0;
  return true;
}

Sim3 MapFromBlock(const double* block) {
  const Rigid3 rigid = PoseFromBlock(block);
  return {std::exp(block[7]), rigid.rotation, rigid.translation};
}

void MapToBlock(const Sim3& map, double* block) {
  PoseToBlock({map.rotation, map.translation}, block);
  block[7] = std::log(map.scale);
}

Rigid3 PoseFromBlock(const double* block) {
  return {Quaterniond(Map<const Quaterniond>(block)).normalized(), Map<const Vector3d>(block + 4)};
}

void PoseToBlock(const Rigid3& pose, double* block) {
  Map<Eigen::Vector4d>(block, 4) = pose.rotation.normalized().coeffs();
  Map<Vector3d>(block + 4) = pose.translation;
}

}  // namespace planegraph
