#pragma once

#include <ceres/manifold.h>

#include <Eigen/Core>

namespace planegraph {

/// Other ways to step from plane to plane than PlaneManifold's, on the same block (unit normal n,
/// offset e from the anchor o). They are there to compare parametrizations: the minimum of a cost
/// does not depend on them, the way there does.

/// Closest point of the plane to a reference point, CP = d n (Geneva et al. 2018): tangent the
/// change of CP in metres. `arm`: from the reference to the anchor, so that d = e + n . arm.
/// Singular for planes through the reference, which therefore has to lie beside the plane: steps of
/// n have no bound there, and |d| is taken as 1e-6 m at least.
class ClosestPointManifold final : public ceres::Manifold {
 public:
  explicit ClosestPointManifold(const Eigen::Vector3d& arm) : arm_(arm) {}
  int AmbientSize() const override { return 4; }
  int TangentSize() const override { return 3; }
  bool Plus(const double* x, const double* delta, double* x_plus_delta) const override;
  bool PlusJacobian(const double* x, double* jacobian) const override;
  bool Minus(const double* y, const double* x, double* y_minus_x) const override;
  bool MinusJacobian(const double* x, double* jacobian) const override;

 private:
  double Distance(const double* x) const;
  Eigen::Vector3d arm_;
};

/// Unit 4-vector q = (n, e / u) / |.| as a quaternion (Kaess 2015): Plus(q, delta) = q Exp(delta),
/// delta half a rotation's angle. The unit of length u weighs metres against radians. Steps beyond
/// the plane at infinity fail.
class UnitQuaternionManifold final : public ceres::Manifold {
 public:
  explicit UnitQuaternionManifold(double unit_length) : unit_(unit_length) {}
  int AmbientSize() const override { return 4; }
  int TangentSize() const override { return 3; }
  bool Plus(const double* x, const double* delta, double* x_plus_delta) const override;
  bool PlusJacobian(const double* x, double* jacobian) const override;
  bool Minus(const double* y, const double* x, double* y_minus_x) const override;
  bool MinusJacobian(const double* x, double* jacobian) const override;

 private:
  Eigen::Vector4d ToQuaternion(const double* x) const;
  double unit_;
};

/// Unit quaternions as 4-vectors (vector part, scalar): a * b, and the vector w of a unit
/// quaternion (w sinc|w|, cos|w|), |w| <= pi / 2 where the scalar is made positive.
Eigen::Vector4d MultiplyQuaternions(const Eigen::Vector4d& a, const Eigen::Vector4d& b);
Eigen::Vector4d ConjugateQuaternion(const Eigen::Vector4d& q);
Eigen::Vector3d HalfAngleLog(Eigen::Vector4d q);
/// The derivative of HalfAngleLog by the four numbers of a unit quaternion, along its sphere.
Eigen::Matrix<double, 3, 4> HalfAngleLogJacobian(const Eigen::Vector4d& q);

}  // namespace planegraph
