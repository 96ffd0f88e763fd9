#pragma once

#include <ceres/manifold.h>

#include <Eigen/Core>
#include <cmath>

#include "planegraph/geometry/rigid3.h"
#include "planegraph/geometry/sim3.h"

namespace planegraph {

/// Own manifolds with tangents in metres and radians. Ceres' quaternion manifold takes half angles
/// and its sphere manifold changed its unit between 2.1 and 2.2; these are the same under both.

inline constexpr int kPoseSize = 7, kPoseTangent = 6;
inline constexpr int kPlaneSize = 4, kPlaneTangent = 3;
inline constexpr int kMapSize = 8, kMapTangent = 7;

/// A rigid motion, stored qx qy qz qw tx ty tz. Tangent x y z rx ry rz: the decoupled left
/// perturbation R <- Exp(r) R, t <- t + x in the target's axes, metres and radians.
class Se3Manifold final : public ceres::Manifold {
 public:
  int AmbientSize() const override { return kPoseSize; }
  int TangentSize() const override { return kPoseTangent; }
  bool Plus(const double* x, const double* delta, double* x_plus_delta) const override;
  bool PlusJacobian(const double* x, double* jacobian) const override;
  bool Minus(const double* y, const double* x, double* y_minus_x) const override;
  bool MinusJacobian(const double* x, double* jacobian) const override;
};

/// A unit vector n in R^3, moved along great circles: Plus(n, d) = cos|d| n + sin|d| B d/|d| with
/// B = TangentBasis(n), radians.
class UnitVectorManifold final : public ceres::Manifold {
 public:
  int AmbientSize() const override { return 3; }
  int TangentSize() const override { return 2; }
  bool Plus(const double* x, const double* delta, double* x_plus_delta) const override;
  bool PlusJacobian(const double* x, double* jacobian) const override;
  bool Minus(const double* y, const double* x, double* y_minus_x) const override;
  bool MinusJacobian(const double* x, double* jacobian) const override;
};

/// A plane: unit normal and offset e (metres) from an anchor o: n . (p - o) = e. Tangent: the two
/// of the unit vector (radians), then the offset (metres).
class PlaneManifold final : public ceres::Manifold {
 public:
  int AmbientSize() const override { return kPlaneSize; }
  int TangentSize() const override { return kPlaneTangent; }
  bool Plus(const double* x, const double* delta, double* x_plus_delta) const override;
  bool PlusJacobian(const double* x, double* jacobian) const override;
  bool Minus(const double* y, const double* x, double* y_minus_x) const override;
  bool MinusJacobian(const double* x, double* jacobian) const override;

 private:
  UnitVectorManifold normal_;
};

/// A similarity, stored qx qy qz qw tx ty tz log(s). Tangent x y z rx ry rz l: as Se3Manifold, and
/// s <- s exp(l).
class Sim3Manifold final : public ceres::Manifold {
 public:
  int AmbientSize() const override { return kMapSize; }
  int TangentSize() const override { return kMapTangent; }
  bool Plus(const double* x, const double* delta, double* x_plus_delta) const override;
  bool PlusJacobian(const double* x, double* jacobian) const override;
  bool Minus(const double* y, const double* x, double* y_minus_x) const override;
  bool MinusJacobian(const double* x, double* jacobian) const override;

 private:
  Se3Manifold rigid_;
};

/// Reads and writes a map block.
Sim3 MapFromBlock(const double* block);
void MapToBlock(const Sim3& map, double* block);

/// Reads and writes a pose block.
Rigid3 PoseFromBlock(const double* block);
void PoseToBlock(const Rigid3& pose, double* block);

/// Rotation matrix and translation of a pose block, for use inside cost functions.
struct PoseView {
  static constexpr int kSize = kPoseSize;
  static constexpr double scale = 1.0;

  explicit PoseView(const double* block)
      : q(block), t(block + 4), rotation(Eigen::Quaterniond(q).toRotationMatrix()) {}
  Eigen::Map<const Eigen::Vector4d> q;
  Eigen::Map<const Eigen::Vector3d> t;
  Eigen::Matrix3d rotation;

  /// Fills one row (7 numbers) of an ambient Jacobian from the row of the tangent Jacobian,
  /// (d/dx, d/dr): J_ambient = J_tangent * MinusJacobian. Ceres multiplies it by PlusJacobian, and
  /// the tangent row comes back.
  void SetRow(const Eigen::Vector3d& dx, const Eigen::Vector3d& dr, double* row) const {
    Eigen::Map<Eigen::Vector3d>(row, 3) = 2.0 * (q[3] * dr + dr.cross(q.head<3>()));
    row[3] = -2.0 * dr.dot(q.head<3>());
    Eigen::Map<Eigen::Vector3d>(row + 4) = dx;
  }
  /// The same for factors that serve poses and maps alike: a pose has no scale.
  void SetRow(const Eigen::Vector3d& dx, const Eigen::Vector3d& dr, double /*dl*/,
              double* row) const {
    SetRow(dx, dr, row);
  }
};

/// The same for a map block: with its scale, and rows of 8 numbers, the last of them d/dl.
struct MapView : PoseView {
  static constexpr int kSize = kMapSize;

  explicit MapView(const double* block) : PoseView(block), scale(std::exp(block[7])) {}
  double scale;
  void SetRow(const Eigen::Vector3d& dx, const Eigen::Vector3d& dr, double dl, double* row) const {
    PoseView::SetRow(dx, dr, row);
    row[7] = dl;
  }
};

}  // namespace planegraph
