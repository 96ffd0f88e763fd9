#include "pose_graph/edge_model.h"

#include <Eigen/Geometry>
#include <Eigen/SVD>
#include <cmath>
#include <numbers>

#include "planegraph/geometry/rotation.h"

namespace planegraph {
namespace {

using Eigen::Matrix2d;
using Eigen::Matrix3d;
using Eigen::Vector2d;
using Eigen::Vector3d;

// A quarter turn: d/da of a planar rotation is Turn * R.
Matrix2d Turn() { return (Matrix2d() << 0.0, -1.0, 1.0, 0.0).finished(); }

// The quaternion of a rotation matrix with w >= 0.
Eigen::Quaterniond PositiveQuaternion(const Matrix3d& rotation) {
  Eigen::Quaterniond q(rotation);
  if (q.w() < 0.0) q.coeffs() = -q.coeffs();
  return q;
}

double RotationPart(double angle, RotationResidual kind) {
  return kind == RotationResidual::kAngle ? angle : std::sin(0.5 * angle);
}

struct Relative2 {
  Vector2d d;               // R_from^T (t_to - t_from)
  Matrix2d to_in_measured;  // E = Z^T R_from^T R_to
  double angle;             // of E, (-pi, pi]
};

Relative2 Relate(const GraphPose<2>& from, const GraphPose<2>& to, const GraphEdge<2>& edge) {
  Relative2 relative;
  relative.d = from.rotation.transpose() * (to.translation - from.translation);
  relative.to_in_measured =
      edge.measurement.rotation.transpose() * (from.rotation.transpose() * to.rotation);
  relative.angle = std::atan2(relative.to_in_measured(1, 0), relative.to_in_measured(0, 0));
  return relative;
}

void Curve(const GraphEdge<2>& edge, RotationResidual kind, const Relative2& relative,
           EdgeModel<2>* model) {
  const Vector3d weighted = edge.information * model->residual;
  const Vector2d p = edge.measurement.rotation * weighted.head<2>();
  const double half =
      kind == RotationResidual::kAngle ? 0.0 : -0.25 * std::sin(0.5 * relative.angle) * weighted[2];
  // p . (Exp(-a) (d + E' x_to - x_from)) to the second order in the unknowns.
  const Eigen::RowVector2d along = -(Turn().transpose() * p).transpose();
  model->curvature_from.setZero();
  model->curvature_to.setZero();
  model->curvature_cross.setZero();
  model->curvature_from(2, 2) = half - p.dot(relative.d);
  model->curvature_from.block<1, 2>(2, 0) = -along;
  model->curvature_from.block<2, 1>(0, 2) = -along.transpose();
  model->curvature_to(2, 2) = half;
  model->curvature_cross(2, 2) = -half;
  model->curvature_cross.block<1, 2>(2, 0) =
      along * (edge.measurement.rotation * relative.to_in_measured);
}

struct Relative3 {
  Vector3d d;
  Matrix3d to_in_measured;
  Eigen::Quaterniond q;  // of to_in_measured
};

Relative3 Relate(const GraphPose<3>& from, const GraphPose<3>& to, const GraphEdge<3>& edge) {
  Relative3 relative;
  relative.d = from.rotation.transpose() * (to.translation - from.translation);
  relative.to_in_measured =
      edge.measurement.rotation.transpose() * (from.rotation.transpose() * to.rotation);
  relative.q = PositiveQuaternion(relative.to_in_measured);
  return relative;
}

void Curve(const GraphEdge<3>& edge, const Relative3& relative, EdgeModel<3>* model) {
  using Vector6 = Eigen::Matrix<double, 6, 1>;
  const Vector6 weighted = edge.information * model->residual;
  const Matrix3d& z = edge.measurement.rotation;
  const Vector3d p = z * weighted.head<3>(), s = weighted.tail<3>(), v = relative.q.vec();
  const Matrix3d hat_p = Hat(p), outer = v * s.transpose();
  const double sv = s.dot(v);
  model->curvature_from.setZero();
  model->curvature_to.setZero();
  model->curvature_cross.setZero();
  // p . (Exp(-a) (d + Z E x_to - x_from)) to the second order.
  const Matrix3d pd = p * relative.d.transpose();
  model->curvature_from.bottomRightCorner<3, 3>() =
      0.5 * (pd + pd.transpose()) - (p.dot(relative.d) + 0.25 * sv) * Matrix3d::Identity();
  model->curvature_from.bottomLeftCorner<3, 3>() = -hat_p;
  model->curvature_from.topRightCorner<3, 3>() = hat_p;
  model->curvature_cross.bottomLeftCorner<3, 3>() = hat_p * (z * relative.to_in_measured);
  // s . vec(Exp(-Z^T a) q Exp(b)) to the second order.
  model->curvature_to.bottomRightCorner<3, 3>() = -0.25 * sv * Matrix3d::Identity();
  model->curvature_cross.bottomRightCorner<3, 3>() =
      -0.25 * z * (sv * Matrix3d::Identity() - outer - outer.transpose() - relative.q.w() * Hat(s));
}

}  // namespace

template <>
Eigen::Vector3d EdgeResidual<2>(const GraphPose<2>& from, const GraphPose<2>& to,
                                const GraphEdge<2>& edge, RotationResidual kind) {
  const Relative2 relative = Relate(from, to, edge);
  Vector3d residual;
  residual << edge.measurement.rotation.transpose() * (relative.d - edge.measurement.translation),
      RotationPart(relative.angle, kind);
  return residual;
}

template <>
Eigen::Matrix<double, 6, 1> EdgeResidual<3>(const GraphPose<3>& from, const GraphPose<3>& to,
                                            const GraphEdge<3>& edge, RotationResidual /*kind*/) {
  const Relative3 relative = Relate(from, to, edge);
  Eigen::Matrix<double, 6, 1> residual;
  residual << edge.measurement.rotation.transpose() * (relative.d - edge.measurement.translation),
      relative.q.vec();
  return residual;
}

template <>
void ModelEdge<2>(const GraphPose<2>& from, const GraphPose<2>& to, const GraphEdge<2>& edge,
                  RotationResidual kind, bool curvature, EdgeModel<2>* model) {
  const Relative2 relative = Relate(from, to, edge);
  const Matrix2d back = edge.measurement.rotation.transpose();
  model->residual << back * (relative.d - edge.measurement.translation),
      RotationPart(relative.angle, kind);
  const double slope =
      kind == RotationResidual::kAngle ? 1.0 : 0.5 * std::cos(0.5 * relative.angle);
  model->by_from.setZero();
  model->by_to.setZero();
  model->by_from.topLeftCorner<2, 2>() = -back;
  model->by_from.topRightCorner<2, 1>() = -back * (Turn() * relative.d);
  model->by_from(2, 2) = -slope;
  model->by_to.topLeftCorner<2, 2>() = relative.to_in_measured;
  model->by_to(2, 2) = slope;
  if (curvature) Curve(edge, kind, relative, model);
}

template <>
void ModelEdge<3>(const GraphPose<3>& from, const GraphPose<3>& to, const GraphEdge<3>& edge,
                  RotationResidual /*kind*/, bool curvature, EdgeModel<3>* model) {
  const Relative3 relative = Relate(from, to, edge);
  const Matrix3d back = edge.measurement.rotation.transpose();
  const Matrix3d scalar = relative.q.w() * Matrix3d::Identity(), hat = Hat(relative.q.vec());
  model->residual << back * (relative.d - edge.measurement.translation), relative.q.vec();
  model->by_from.setZero();
  model->by_to.setZero();
  model->by_from.topLeftCorner<3, 3>() = -back;
  model->by_from.topRightCorner<3, 3>() = back * Hat(relative.d);
  model->by_from.bottomRightCorner<3, 3>() = -0.5 * (scalar - hat) * back;
  model->by_to.topLeftCorner<3, 3>() = relative.to_in_measured;
  model->by_to.bottomRightCorner<3, 3>() = 0.5 * (scalar + hat);
  if (curvature) Curve(edge, relative, model);
}

template <>
GraphPose<2> Retract<2>(const GraphPose<2>& pose, const Eigen::Vector3d& step) {
  const Eigen::Rotation2Dd turn(step[2]);
  return {pose.rotation * turn.toRotationMatrix(),
          pose.translation + pose.rotation * step.head<2>()};
}

template <>
GraphPose<3> Retract<3>(const GraphPose<3>& pose, const Eigen::Matrix<double, 6, 1>& step) {
  return {pose.rotation * ExpSO3(step.tail<3>()).toRotationMatrix(),
          pose.translation + pose.rotation * step.head<3>()};
}

template <>
Eigen::Matrix2d NearestRotation<2>(const Eigen::Matrix2d& matrix) {
  const double angle = std::atan2(matrix(1, 0) - matrix(0, 1), matrix(0, 0) + matrix(1, 1));
  return Eigen::Rotation2Dd(angle).toRotationMatrix();
}

template <>
Eigen::Matrix3d NearestRotation<3>(const Eigen::Matrix3d& matrix) {
  return ProjectToRotation(matrix);
}

}  // namespace planegraph
