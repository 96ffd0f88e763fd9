#pragma once

#include <cmath>
#include <vector>

#include "pose_graph/block_cholesky.h"
#include "pose_graph/connection_blocks.h"

namespace planegraph {

/// The dual matrix S = M - Lambda over blocks (rotation, translation) of each pose. The translation
/// of one pose in each part of the graph is left out: it changes nothing.
template <int Dim>
class DualMatrix {
 public:
  static constexpr int kBlock = Dim + 1;
  using Block = Eigen::Matrix<double, kBlock, kBlock>;
  using Small = Eigen::Matrix<double, Dim, Dim>;

  /// All of them have to outlive it.
  DualMatrix(const PoseGraph<Dim>& graph, const ConnectionBlocks<Dim>& blocks,
             const std::vector<bool>& held, const BlockPattern& pattern)
      : graph_(graph), blocks_(blocks), held_(held), matrix_(pattern, kBlock) {}

  /// S + eta on the rotations: positive definite?
  bool IsPositive(const std::vector<Small>& multipliers, double eta) {
    Assemble(multipliers, eta);
    return matrix_.Factorize();
  }

  /// After IsPositive(..., eta) was true for an eta that is little more than needed: the direction
  /// in which the rotations' curvature is most negative, by inverse iteration.
  Eigen::MatrixXd SteepestDescent() const {
    constexpr int kSteps = 30;
    const int rows = static_cast<int>(held_.size()) * kBlock;
    Eigen::MatrixXd v(rows, 1);
    // Any start that is no eigenvector will do; the same one in every run.
    for (int i = 0; i < rows; ++i) v(i, 0) = std::sin(1.0 + 0.7 * i + 0.013 * i * i);
    for (int step = 0; step < kSteps; ++step) {
      for (int i = Dim; i < rows; i += kBlock) v(i, 0) = 0.0;
      v = matrix_.Solve(v / v.norm());
    }
    return Eigen::Map<const Eigen::Matrix<double, Eigen::Dynamic, kBlock, Eigen::RowMajor>>(
        v.data(), rows / kBlock, kBlock);
  }

 private:
  void Assemble(const std::vector<Small>& multipliers, double eta) {
    matrix_.SetZero();
    for (int i = 0; i < static_cast<int>(held_.size()); ++i) {
      Block block = blocks_.diagonal[i];
      block.template topLeftCorner<Dim, Dim>() -= multipliers[i];
      block.diagonal().template head<Dim>().array() += eta;
      if (held_[i]) {
        block.row(Dim).setZero();
        block.col(Dim).setZero();
        block(Dim, Dim) = 1.0;
      }
      matrix_.template Diagonal<kBlock>(i) = block;
    }
    for (std::size_t k = 0; k < graph_.edges.size(); ++k) {
      Block cross = blocks_.cross[k];
      if (held_[graph_.edges[k].from]) cross.row(Dim).setZero();
      if (held_[graph_.edges[k].to]) cross.col(Dim).setZero();
      matrix_.template AddPair<kBlock>(static_cast<int>(k), cross);
    }
  }

  const PoseGraph<Dim>& graph_;
  const ConnectionBlocks<Dim>& blocks_;
  const std::vector<bool>& held_;
  BlockCholesky matrix_;
};

}  // namespace planegraph
