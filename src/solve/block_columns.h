#pragma once

#include <Eigen/Core>
#include <Eigen/SparseCore>
#include <vector>

namespace planegraph {

/// The lower half of a symmetric matrix, or a lower factor, in dense block columns over the blocks
/// that a sparse matrix has. Rows and columns come in consecutive blocks.
class BlockColumns {
 public:
  /// `first_row` of each block, increasing, and the number of rows after them. Every block of
  /// `lower` counts as full.
  BlockColumns(const Eigen::SparseMatrix<double>& lower, std::vector<int> first_row);

  int count() const { return static_cast<int>(values_.size()); }
  int Size(int block) const { return first_row_[block + 1] - first_row_[block]; }
  /// The block rows of a column, the diagonal one first, and where each begins in its values.
  const std::vector<int>& Rows(int column) const { return rows_[column]; }
  const std::vector<int>& Starts(int column) const { return starts_[column]; }
  Eigen::MatrixXd& Values(int column) { return values_[column]; }
  const Eigen::MatrixXd& Values(int column) const { return values_[column]; }
  /// Where block `row` (>= column) begins in a column's values; -1: it is not there.
  int Find(int row, int column) const;
  /// A block that is there, above the diagonal by its transpose.
  Eigen::MatrixXd Block(int row, int column) const;
  /// Over the rows below a column's diagonal block, which elimination has tied to each other.
  Eigen::MatrixXd Below(int column) const;
  /// Adds the lower half of a symmetric matrix over these rows.
  void AddBelow(int column, const Eigen::MatrixXd& below);
  /// All values zero, then those of a sparse matrix with no other blocks.
  void Set(const Eigen::SparseMatrix<double>& lower);

 private:
  void SetRows(const Eigen::SparseMatrix<double>& lower, int column);

  std::vector<int> first_row_, block_of_;
  std::vector<std::vector<int>> rows_, starts_;
  std::vector<Eigen::MatrixXd> values_;
};

}  // namespace planegraph
