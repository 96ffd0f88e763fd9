#pragma once

#include <Eigen/Core>
#include <Eigen/Eigenvalues>
#include <cmath>
#include <map>
#include <utility>
#include <vector>

#include "solve/information.h"

namespace planegraph {

/// Pseudo-inverse of a plane's 3x3 block (or that of several), judged after scaling to unit
/// diagonal (radians and metres). A plane that one weak observation alone sees has directions
/// without information.
template <typename Matrix>
Matrix PseudoInverse(const Matrix& h) {
  using Vector = Eigen::Matrix<double, Matrix::RowsAtCompileTime, 1>;
  const Vector scale =
      h.diagonal().unaryExpr([](double d) { return d > 0.0 ? 1.0 / std::sqrt(d) : 0.0; });
  const Eigen::SelfAdjointEigenSolver<Matrix> solver(scale.asDiagonal() * h * scale.asDiagonal());
  const Vector inverse =
      solver.eigenvalues().unaryExpr([](double v) { return v > 1e-12 ? 1.0 / v : 0.0; });
  const Matrix scaled =
      solver.eigenvectors() * inverse.asDiagonal() * solver.eigenvectors().transpose();
  return scale.asDiagonal() * scaled * scale.asDiagonal();
}

/// The normal equations of planes that are eliminated together, all by the sums over residuals of
/// J^T J (h) and J^T F J (m), with F the scatter of the residuals' rows.
class GroupSystem {
 public:
  GroupSystem(const std::vector<const PlaneResidual*>& residuals, const PoseInformation& nodes);

  /// First row and dimension of each node in the reduction.
  const std::map<int, std::pair<int, int>>& nodes() const { return nodes_; }
  int rows() const { return rows_; }
  /// What the planes take from the nodes' information.
  Eigen::MatrixXd Reduction() const { return -h_lp_.transpose() * inverse_ * h_lp_; }
  /// And from the scatter of their scores.
  Eigen::MatrixXd ScatterReduction() const;
  PlaneElimination Eliminate(int plane) const;
  /// A residual's Jacobian by the planes, in the group's rows.
  Eigen::MatrixXd ByPlanes(const PlaneResidual& residual) const;
  const Eigen::MatrixXd& inverse() const { return inverse_; }      ///< of the planes' own part
  const Eigen::MatrixXd& following() const { return following_; }  ///< inverse h_lp

 private:
  void Place(const PlaneResidual& residual);
  void Add(const PlaneResidual& residual);

  const PoseInformation& numbers_;
  std::map<int, int> place_;  // first row of each plane
  std::map<int, std::pair<int, int>> nodes_;
  int planes_ = 0, rows_ = 0;
  Eigen::MatrixXd h_ll_, h_lp_, m_ll_, m_lp_, inverse_, following_;
};

}  // namespace planegraph
