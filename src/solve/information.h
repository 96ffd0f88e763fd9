#pragma once

#include <map>
#include <utility>
#include <vector>

#include "solve/assembly.h"

namespace planegraph {

/// What two nodes (poses of six dimensions, maps of seven) have in common; no heap.
using NodeBlock = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::ColMajor, 7, 7>;

/// A symmetric matrix over the nodes of a graph, its poses first, then its maps; upper blocks (row
/// <= column) only.
class PoseInformation {
 public:
  explicit PoseInformation(std::size_t pose_count) : pose_count_(static_cast<int>(pose_count)) {}

  int pose_count() const { return pose_count_; }
  /// The node of a pose's or a map's block.
  int NodeOf(const BlockRef& block) const {
    return block.kind == BlockKind::kMap ? pose_count_ + block.index : block.index;
  }
  /// Adds `block` at (row, column), or its transpose where that is the lower half. A diagonal block
  /// is taken as it is.
  void Add(int row, int column, const NodeBlock& block);
  /// The block of one pose; zero where there is none.
  Matrix6d Diagonal(int pose) const;
  const std::map<std::pair<int, int>, NodeBlock>& blocks() const { return blocks_; }

 private:
  int pose_count_;
  std::map<std::pair<int, int>, NodeBlock> blocks_;
};

/// A factor of poses or maps, linearized: its Jacobians by the world perturbations of its nodes.
struct LinearizedPoseFactor {
  ResidualTag tag;
  std::array<BlockRef, 2> blocks;
  int block_count = 0;
  std::array<Eigen::MatrixXd, 2> jacobians;
};

/// Adds the information of residuals that all belong to one plane (linearized), the plane
/// eliminated by Schur's complement: H_pp - H_pl H_ll^+ H_lp.
struct PlaneResidual {
  std::array<BlockRef, 2> blocks;
  int block_count = 0;
  ResidualTag tag;
  LinearizedResidual linear;
};
void AddPlaneInformation(const std::vector<const PlaneResidual*>& residuals, double weight,
                         PoseInformation* information);

/// The linearized residuals of each plane of the graph, and of its pose factors.
struct LinearizedGraph {
  std::vector<std::vector<PlaneResidual>> planes;
  std::vector<LinearizedPoseFactor> pose_factors;
};
LinearizedGraph LinearizeGraph(const Graph& graph, const SolveOptions& options);

void AddPoseFactorInformation(const LinearizedPoseFactor& factor, PoseInformation* information);

}  // namespace planegraph
