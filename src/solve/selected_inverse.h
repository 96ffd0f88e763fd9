#pragma once

#include "solve/block_factor.h"

namespace planegraph {

/// The blocks of A^-1 at the places where the Cholesky factor L of A = L L^T has some, without any
/// other block of the inverse (Takahashi, Fagan and Chen 1973; Erisman and Tinney 1975). Rows and
/// columns are nodes of the factor's structure.
class SelectedInverse {
 public:
  explicit SelectedInverse(const BlockFactor& factor);

  /// Whether the block is there, row >= column.
  bool Has(int row, int column) const { return columns_.Has(row, column); }
  /// A block that is there.
  NodeBlock Block(int row, int column) const { return columns_.Block(row, column); }
  const BlockColumns& columns() const { return columns_; }

 private:
  void Invert(int column);

  BlockColumns columns_;  // first those of L, then those of the inverse
};

/// The blocks of A^-1 B A^-1 at the same places, for a B that has no other blocks than A. It is the
/// derivative of -(A + e B)^-1 by e: the elimination and Takahashi's equations, differentiated.
class SelectedSandwich {
 public:
  /// `scatter`: the lower half of B; `inverse`: that of the same factor.
  SelectedSandwich(const BlockFactor& factor, const Eigen::SparseMatrix<double>& scatter,
                   const SelectedInverse& inverse);

  /// A block that is there (SelectedInverse::Has).
  NodeBlock Block(int row, int column) const { return -columns_.Block(row, column); }

 private:
  void Eliminate(const BlockColumns& lower, int column);
  void Invert(const BlockColumns& lower, const BlockColumns& inverse, int column);

  BlockColumns columns_;  // first B, eliminated on the spot, then the inverse's derivative
};

}  // namespace planegraph
