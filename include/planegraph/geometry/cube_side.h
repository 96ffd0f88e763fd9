#pragma once

#include <Eigen/Core>

namespace planegraph {

/// The side of a cube about the origin that a direction goes through (0 to 5: +x -x +y -y +z -z),
/// of equal ones the first axis.
template <typename Scalar>
int CubeSide(const Eigen::Matrix<Scalar, 3, 1>& direction) {
  // Selections rather than branches: the sides of successive directions are hard to foresee.
  const Eigen::Matrix<Scalar, 3, 1> size = direction.cwiseAbs();
  const bool x_first = size.x() >= size.y() && size.x() >= size.z();
  const bool y_first = size.y() >= size.z();
  const Scalar along = x_first ? direction.x() : y_first ? direction.y() : direction.z();
  return 2 * (x_first ? 0 : y_first ? 1 : 2) + (along < 0 ? 1 : 0);
}

}  // namespace planegraph
