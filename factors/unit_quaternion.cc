// Plane landmark as a unit 4-vector, compared like quaternions (Kaess 2015):
//
//   r = W log(q_m^-1 q')      q = (n, d / u) / |.|,  n' = R^T n,  d' = e + n . (o - t)
//
// q_m of the measured plane (n_m, s n_m . c) in the node's frame; (s, R, t): world_from_node, s = 1
// for a pose; n, e: the landmark's normal and its offset from the anchor o; u: the unit of length.
// log takes half the angle, of q or -q. W carries the information of tilt and offset over the
// derivative of the log at the measurement. The metric depends on the unit and on the distance of
// the plane: what is far counts as the same plane at infinity. The landmark steps in the same way
// (UnitQuaternionManifold).
#include <Eigen/Geometry>
#include <Eigen/LU>

#include "factors/plane_in_node.h"
#include "planegraph/graph/plane_charts.h"

namespace planegraph {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using Eigen::Vector4d;
using Matrix4d = Eigen::Matrix4d;

constexpr double kDefaultUnit = 1.0;  // metres

// The matrix of the multiplication by q from the left.
Matrix4d LeftMultiplication(const Vector4d& q) {
  Matrix4d matrix;
  for (int k = 0; k < 4; ++k) matrix.col(k) = MultiplyQuaternions(q, Vector4d::Unit(k));
  return matrix;
}

// q of (n, d) with its derivative by the four numbers (n, d).
struct UnitFourVector {
  UnitFourVector(const Vector3d& n, double d, double unit) {
    const Vector4d raw(n.x(), n.y(), n.z(), d / unit);
    const double length = raw.norm();
    q = raw / length;
    jacobian = (Matrix4d::Identity() - q * q.transpose()) / length;
    jacobian.col(3) /= unit;
  }
  Vector4d q;
  Matrix4d jacobian;
};

class UnitQuaternion {
 public:
  UnitQuaternion(const MeasuredPlane& measured, const FactorOptions& options)
      : normal_(measured.normal),
        distance_(measured.distance),
        unit_(OptionOr(options, "unit_length", kDefaultUnit)) {
    const UnitFourVector q(normal_, measured.scale * distance_, unit_);
    const Matrix4d to_error = LeftMultiplication(ConjugateQuaternion(q.q)) * q.jacobian;
    Eigen::Matrix<double, 4, 3> by_tilt_and_offset = Eigen::Matrix<double, 4, 3>::Zero();
    by_tilt_and_offset.col(0).head<3>() = measured.axis_1;
    by_tilt_and_offset.col(1).head<3>() = measured.axis_2;
    by_tilt_and_offset(3, 2) = 1.0;
    const Matrix3d by_error = (to_error * by_tilt_and_offset).topRows<3>();
    whitening_ = measured.root * by_error.inverse();
  }

  PlaneComparison operator()(const Vector3d& n, double d, double scale) const {
    const UnitFourVector predicted(n, d, unit_), measured(normal_, scale * distance_, unit_);
    const Matrix4d left = LeftMultiplication(ConjugateQuaternion(measured.q));
    const Vector4d difference = left * predicted.q;
    const Eigen::Matrix<double, 3, 4> by_difference = whitening_ * HalfAngleLogJacobian(difference);
    const Eigen::Matrix<double, 3, 4> by_plane = by_difference * left * predicted.jacobian;
    const Vector4d measured_by_log_scale = scale * distance_ * measured.jacobian.col(3);
    return {whitening_ * HalfAngleLog(difference), by_plane.leftCols<3>(), by_plane.col(3),
            by_difference *
                MultiplyQuaternions(ConjugateQuaternion(measured_by_log_scale), predicted.q)};
  }

 private:
  Vector3d normal_;
  double distance_, unit_;
  Matrix3d whitening_;
};

}  // namespace

void Register_unit_quaternion(FactorRegistry* registry) {
  FactorType type;
  type.name = "unit_quaternion";
  type.description = "plane landmark as a unit 4-vector, compared like quaternions";
  type.residual =
      "logarithm of the measured 4-vector (n, d / unit_length) inverted times the predicted one "
      "(half the angle, node's frame), whitened";
  type.parameters = {
      {"unit_length", "m", "length that counts like one radian", kDefaultUnit, false}};
  type.make_manifold = [](const Eigen::Vector3d& anchor, const FactorOptions& options) {
    return std::make_unique<UnitQuaternionManifold>(anchor,
                                                    OptionOr(options, "unit_length", kDefaultUnit));
  };
  RegisterPlaneInNode<UnitQuaternion>(std::move(type), kDefaultUnit, registry);
}

}  // namespace planegraph
