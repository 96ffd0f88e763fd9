#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>

namespace planegraph {

/// The 3x3 matrix of the cross product: Hat(a) b = a x b.
Eigen::Matrix3d Hat(const Eigen::Vector3d& a);

/// Unit quaternion of the rotation vector (axis times angle, radians).
Eigen::Quaterniond ExpSO3(const Eigen::Vector3d& rotation_vector);

/// Rotation vector of a unit quaternion, of length in [0, pi]; exact near 0 and near pi.
Eigen::Vector3d LogSO3(const Eigen::Quaterniond& rotation);

/// Angle between two rotations, radians in [0, pi].
double AngleBetween(const Eigen::Quaterniond& a, const Eigen::Quaterniond& b);

/// Two unit vectors that with the unit vector `normal` form a right-handed basis (columns u, v:
/// u x v = normal).
Eigen::Matrix<double, 3, 2> TangentBasis(const Eigen::Vector3d& normal);

/// Rotation R that minimizes |R - M|_F for a 3x3 matrix M, with det R = +1 (SVD with determinant
/// correction).
Eigen::Matrix3d ProjectToRotation(const Eigen::Matrix3d& matrix);

}  // namespace planegraph
