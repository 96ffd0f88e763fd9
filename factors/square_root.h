#pragma once

#include <Eigen/Eigenvalues>

namespace planegraph {

/// L with L^T L = information, of any rank.
template <int kSize>
Eigen::Matrix<double, kSize, kSize> SquareRoot(
    const Eigen::Matrix<double, kSize, kSize>& information) {
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix<double, kSize, kSize>> solver(information);
  return solver.eigenvalues().cwiseMax(0.0).cwiseSqrt().asDiagonal() *
         solver.eigenvectors().transpose();
}

}  // namespace planegraph
