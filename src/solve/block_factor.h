#pragma once

#include <Eigen/SparseCore>

#include "solve/block_columns.h"

namespace planegraph {

/// The Cholesky factor L of a symmetric matrix A = L L^T, by dense columns. Selected inversion
/// needs the factor by nodes of one to seven rows, which neither CHOLMOD nor Eigen gives.
class BlockFactor {
 public:
  /// The structure has to outlive it.
  explicit BlockFactor(const FactorStructure& structure) : columns_(structure) {}

  /// `lower`: the lower half of A, with no blocks that the structure has not. False where it is not
  /// (numerically) positive definite.
  bool Factorize(const Eigen::SparseMatrix<double>& lower);
  /// x of A x = b.
  Eigen::MatrixXd Solve(Eigen::MatrixXd b) const;
  /// Of the columns' own nodes the lower half is the factor's, the upper one undefined.
  const BlockColumns& columns() const { return columns_; }

 private:
  BlockColumns columns_;
};

}  // namespace planegraph
