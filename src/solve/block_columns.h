#pragma once

#include <Eigen/Core>
#include <Eigen/SparseCore>
#include <vector>

namespace planegraph {

/// What two nodes (poses of six dimensions, maps of seven, scales of one) have in common; no heap.
using NodeBlock = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::ColMajor, 7, 7>;

/// Where the Cholesky factor of a symmetric matrix of node blocks has some, in the nodes' own
/// order. Nodes that follow each other and have the same rows below them make one column (a
/// supernode: Ng and Peyton 1993), so that dense products do the work.
struct FactorStructure {
  std::vector<int> first_row;          ///< of each node, and the number of rows
  std::vector<int> column_of;          ///< of each node
  std::vector<std::vector<int>> rows;  ///< nodes of each column: its own, then those below

  /// `below`: of each node those of greater number that the matrix ties it to, in any order.
  FactorStructure(std::vector<int> node_rows, std::vector<std::vector<int>> below);
};

/// The lower half of a symmetric matrix, or a lower factor, in the dense columns of a structure.
class BlockColumns {
 public:
  /// All values zero. The structure has to outlive it.
  explicit BlockColumns(const FactorStructure& structure);

  int count() const { return static_cast<int>(values_.size()); }
  /// The rows of the column's own nodes come first: Width() of them.
  Eigen::MatrixXd& Values(int column) { return values_[column]; }
  const Eigen::MatrixXd& Values(int column) const { return values_[column]; }
  Eigen::Index Width(int column) const { return values_[column].cols(); }
  /// The first row of a column's nodes in the whole matrix.
  int FirstRow(int column) const { return structure_.first_row[structure_.rows[column].front()]; }

  /// Whether the block of two nodes is there, row >= column.
  bool Has(int row, int column) const { return Find(row, structure_.column_of[column]) >= 0; }
  /// A block that is there, above the diagonal by its transpose.
  NodeBlock Block(int row, int column) const;
  /// Over the rows below a column's own nodes, which elimination has tied to each other.
  Eigen::MatrixXd Below(int column) const;
  /// Adds the lower half of a symmetric matrix over these rows.
  void AddBelow(int column, const Eigen::MatrixXd& below);
  /// The rows below a column's own nodes of a matrix over all rows; and back.
  Eigen::MatrixXd GatherBelow(int column, const Eigen::MatrixXd& all) const;
  void SubtractBelow(int column, const Eigen::MatrixXd& below, Eigen::MatrixXd* all) const;
  /// All values zero, then those of a sparse matrix with no other blocks.
  void Set(const Eigen::SparseMatrix<double>& lower);

 private:
  int Size(int node) const { return structure_.first_row[node + 1] - structure_.first_row[node]; }
  /// Where a node's rows begin in a column's values; -1: it is not there.
  int Find(int row, int column) const;
  /// Where a node's own column begins in the values of the column that it is in.
  int Offset(int node) const { return structure_.first_row[node] - FirstRow(ColumnOf(node)); }
  int ColumnOf(int node) const { return structure_.column_of[node]; }
  std::size_t OwnNodes(int column) const;
  template <typename Function>
  void ForEachBelow(int column, const Function& function) const;

  const FactorStructure& structure_;
  std::vector<std::vector<int>> starts_;  // of each column's nodes in its values, and their end
  std::vector<Eigen::MatrixXd> values_;
};

}  // namespace planegraph
