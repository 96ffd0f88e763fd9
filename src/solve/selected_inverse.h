#pragma once

#include <Eigen/Core>
#include <Eigen/SparseCore>
#include <vector>

namespace planegraph {

/// The blocks of A^-1 at the places where the Cholesky factor L of A = L L^T has some, without any
/// other block of the inverse (Takahashi, Fagan and Chen 1973; Erisman and Tinney 1975). Rows and
/// columns of A come in consecutive blocks.
class SelectedInverse {
 public:
  /// `first_row` of each block, increasing, and the number of rows after them. Every block of
  /// `lower` counts as full.
  SelectedInverse(const Eigen::SparseMatrix<double>& lower, std::vector<int> first_row);

  /// Whether the block is there; rows and columns are block indices.
  bool Has(int row, int column) const { return Find(row, column) >= 0; }
  /// A block that is there.
  Eigen::MatrixXd Block(int row, int column) const;

 private:
  int Size(int block) const { return first_row_[block + 1] - first_row_[block]; }
  // Where block `row` of a column begins, in values_ and in heights; -1: nowhere.
  int Find(int row, int column) const;
  void Take(const Eigen::SparseMatrix<double>& lower);
  void SetRows(const Eigen::SparseMatrix<double>& lower, const std::vector<int>& block_of,
               int column);
  void Invert(int column);
  Eigen::MatrixXd Below(int column) const;

  std::vector<int> first_row_;
  // Of each block column its block rows (the diagonal one first), where they begin, and the values
  // of one below the other: first those of L, then those of the inverse.
  std::vector<std::vector<int>> rows_, starts_;
  std::vector<Eigen::MatrixXd> values_;
};

}  // namespace planegraph
