#pragma once

#include "solve/block_columns.h"

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
  bool Has(int row, int column) const { return columns_.Find(row, column) >= 0; }
  /// A block that is there.
  Eigen::MatrixXd Block(int row, int column) const { return columns_.Block(row, column); }
  const BlockColumns& columns() const { return columns_; }

 private:
  void Invert(int column);

  BlockColumns columns_;  // first those of L, then those of the inverse
};

/// The blocks of A^-1 B A^-1 at the same places, for a B that has no other blocks than A. It is the
/// derivative of -(A + e B)^-1 by e: the elimination and Takahashi's equations, differentiated.
class SelectedSandwich {
 public:
  /// `lower`: L; `scatter`: the lower half of B; `inverse`: that of the same L.
  SelectedSandwich(const Eigen::SparseMatrix<double>& lower, std::vector<int> first_row,
                   const Eigen::SparseMatrix<double>& scatter, const SelectedInverse& inverse);

  /// A block that is there (SelectedInverse::Has).
  Eigen::MatrixXd Block(int row, int column) const { return -columns_.Block(row, column); }

 private:
  void Eliminate(const BlockColumns& lower, int column);
  void Invert(const BlockColumns& lower, const BlockColumns& inverse, int column);

  BlockColumns columns_;  // first B, eliminated on the spot, then the inverse's derivative
};

}  // namespace planegraph
