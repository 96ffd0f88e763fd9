#pragma once

#include <Eigen/Eigenvalues>

namespace planegraph {

/// L with L^T L = information, of any rank.
inline Eigen::Matrix3d SquareRoot(const Eigen::Matrix3d& information) {
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(information);
  return solver.eigenvalues().cwiseMax(0.0).cwiseSqrt().asDiagonal() *
         solver.eigenvectors().transpose();
}

}  // namespace planegraph
