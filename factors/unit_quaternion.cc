// Plane landmark as a unit 4-vector, compared like quaternions (Kaess 2015):
//
//   r = W log(q_m^-1 q')      q' = (n', g / u) / |.|,  q_m = (n_m, 0)
//   n' = R^T n,  g = e + n . (o - t) - s n' . c
//
// (s, R, t): world_from_node, s = 1 for a pose; n_m, c: the segment's normal and centroid (node's
// frame); n, e: the landmark's normal and its offset from the anchor o; g: distance of the centroid
// from the landmark (m of the world); u: the unit of length. log takes half the angle, of q or -q.
// W: weights of tilts and offset along -n_m x v_1, -n_m x v_2, -u n_m, which are the log's
// derivatives at the measurement (v_k: in-plane axes).
//
// The origin of the 4-vectors is the centroid, not the node's as published: the metric depends on
// the distance (what is far counts as the same plane at infinity), and so two planes at one place
// would be compared otherwise by a node near them than by one far away. The landmark steps in the
// same way about its anchor (UnitQuaternionManifold).
#include "factors/plane_in_node.h"
#include "planegraph/graph/plane_charts.h"

namespace planegraph {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using Eigen::Vector4d;
using Matrix4d = Eigen::Matrix4d;

constexpr double kDefaultUnit = 1.0;  // metres

double UnitLength(const FactorOptions& options) {
  return OptionOr(options, "unit_length", kDefaultUnit);
}

class UnitQuaternion {
 public:
  UnitQuaternion(const MeasuredPlane& m, const FactorOptions& options)
      : centroid_(m.centroid), unit_(UnitLength(options)) {
    const Vector4d inverse = ConjugateQuaternion({m.normal.x(), m.normal.y(), m.normal.z(), 0.0});
    for (int k = 0; k < 4; ++k) relative_.col(k) = MultiplyQuaternions(inverse, Vector4d::Unit(k));
    whitening_ << -m.tilt_weight_1 * m.normal.cross(m.axis_1).transpose(),
        -m.tilt_weight_2 * m.normal.cross(m.axis_2).transpose(),
        -m.offset_weight * unit_ * m.normal.transpose();
  }

  PlaneComparison operator()(const Vector3d& n, double d, double scale) const {
    const Vector3d arm = scale * centroid_;
    const Vector4d raw(n.x(), n.y(), n.z(), (d - n.dot(arm)) / unit_);
    const double length = raw.norm();
    const Vector4d q = raw / length, difference = relative_ * q;
    const Matrix4d by_raw = relative_ * (Matrix4d::Identity() - q * q.transpose()) / length;
    const Eigen::Matrix<double, 3, 4> by_plane =
        whitening_ * HalfAngleLogJacobian(difference) * by_raw;
    return CompareAtCentroid(whitening_ * HalfAngleLog(difference), by_plane.leftCols<3>(),
                             by_plane.col(3) / unit_, n, arm);
  }

 private:
  Vector3d centroid_;
  double unit_;
  Matrix4d relative_;  // q_m^-1 times
  Matrix3d whitening_;
};

}  // namespace

void Register_unit_quaternion(FactorRegistry* registry) {
  FactorType type;
  type.name = "unit_quaternion";
  type.description = "plane landmark as a unit 4-vector, compared like quaternions";
  type.source =
      "Kaess: Simultaneous localization and mapping with infinite planes, ICRA 2015; origin moved "
      "to the centroid (own)";
  type.residual =
      "logarithm of the measured 4-vector (n, d / unit_length) inverted times the predicted one "
      "(half the angle, node's axes, origin at the segment's centroid), whitened";
  type.parameters = {
      {"unit_length", "m", "length that counts like one radian", kDefaultUnit, false, true}};
  type.make_manifold = [](const PlaneLandmark&, const FactorOptions& options) {
    return std::make_unique<UnitQuaternionManifold>(UnitLength(options));
  };
  RegisterPlaneInNode<UnitQuaternion>(std::move(type), registry);
}

}  // namespace planegraph
