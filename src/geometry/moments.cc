#include "planegraph/geometry/moments.h"

#include <Eigen/Eigenvalues>

namespace planegraph {

PrincipalAxes ComputePrincipalAxes(const Eigen::Matrix3d& symmetric) {
  // The closed form is several times faster than the iteration, and exact enough for well separated
  // eigenvalues; it loses the smallest of them at condition numbers beyond ~1e8, far past any scan.
  Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver;
  solver.computeDirect(symmetric);
  PrincipalAxes axes{solver.eigenvalues().cwiseMax(0.0), solver.eigenvectors()};
  if (axes.vectors.determinant() < 0) axes.vectors.col(2) = -axes.vectors.col(2);
  return axes;
}

}  // namespace planegraph
