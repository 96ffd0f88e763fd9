#pragma once

#include <Eigen/Core>
#include <memory>
#include <utility>
#include <vector>

namespace planegraph {

/// Which blocks of a symmetric block matrix are there: all of the diagonal, and the pairs. Holds
/// the order of elimination with the least fill that AMD and nested dissection find; every matrix
/// over the same graph shares it, whatever the size of its blocks.
class BlockPattern {
 public:
  /// Pairs may occur in either order and more than once; both ends in [0, size), unequal.
  BlockPattern(int size, const std::vector<std::pair<int, int>>& pairs);

  int size() const { return static_cast<int>(position_.size()); }
  /// Place of a block row in the order of elimination.
  int position(int row) const { return position_[row]; }
  /// Blocks of column `position`, the diagonal one first, as increasing row positions.
  const std::vector<int>& column(int position) const { return columns_[position]; }
  /// Of the k-th pair: column position, index within column(), and whether the pair's first end is
  /// the column.
  struct Slot {
    int column = 0, index = 0;
    bool first_is_column = false;
  };
  const Slot& slot(int pair) const { return pair_slots_[pair]; }

 private:
  std::vector<int> position_;
  std::vector<std::vector<int>> columns_;
  std::vector<Slot> pair_slots_;
};

/// Sparse Cholesky factorization of a symmetric matrix of K x K blocks (CHOLMOD).
class BlockCholesky {
 public:
  using Block = Eigen::Map<Eigen::MatrixXd, 0, Eigen::OuterStride<>>;

  BlockCholesky(const BlockPattern& pattern, int block_size);
  ~BlockCholesky();
  BlockCholesky(const BlockCholesky&) = delete;
  BlockCholesky& operator=(const BlockCholesky&) = delete;

  void SetZero();
  /// The diagonal block of a row. Both of its triangles are kept, the upper one is not read.
  template <int K>
  auto Diagonal(int row) {
    return MapAt<K>(pattern_.position(row), 0);
  }
  /// Adds to the block (first end, second end) of the k-th pair of the pattern.
  template <int K>
  void AddPair(int pair, const Eigen::Matrix<double, K, K>& block) {
    const BlockPattern::Slot& slot = pattern_.slot(pair);
    auto stored = MapAt<K>(slot.column, slot.index);
    if (slot.first_is_column) {
      stored += block.transpose();
    } else {
      stored += block;
    }
  }
  /// The same for block sizes that are known at run time alone.
  Block DiagonalBlock(int row) { return BlockAt(pattern_.position(row), 0); }
  void AddPairBlock(int pair, const Eigen::MatrixXd& block);

  /// False where the matrix is not (numerically) positive definite.
  bool Factorize();
  /// x of A x = b, for the last Factorize() that was true. Rows of b and x as the pattern's rows.
  Eigen::MatrixXd Solve(const Eigen::MatrixXd& b) const;

 private:
  template <int K>
  auto MapAt(int column, int index) {
    using Map = Eigen::Map<Eigen::Matrix<double, K, K>, 0, Eigen::OuterStride<>>;
    const int height = static_cast<int>(pattern_.column(column).size()) * block_size_;
    return Map(values_ + offsets_[column] + index * block_size_, Eigen::OuterStride<>(height));
  }

  Block BlockAt(int column, int index);

  const BlockPattern& pattern_;
  int block_size_;
  std::vector<std::size_t> offsets_;  // of each block column's values
  double* values_ = nullptr;          // CHOLMOD's
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace planegraph
