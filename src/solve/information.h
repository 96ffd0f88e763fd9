#pragma once

#include <Eigen/Core>
#include <utility>
#include <vector>

#include "solve/assembly.h"
#include "solve/block_columns.h"

namespace planegraph {

/// The nodes of a graph: its poses first, then its maps, then its scales.
class NodeNumbers {
 public:
  explicit NodeNumbers(const Graph& graph)
      : poses_(static_cast<int>(graph.poses.size())), maps_(static_cast<int>(graph.maps.size())) {}
  /// The node of a pose's, a map's or a scale's block.
  int Of(const BlockRef& block) const {
    if (block.kind == BlockKind::kPose) return block.index;
    return (block.kind == BlockKind::kMap ? poses_ : poses_ + maps_) + block.index;
  }

 private:
  int poses_, maps_;
};

/// A symmetric matrix over the nodes of a graph; upper blocks (row <= column) only.
class PoseInformation {
 public:
  explicit PoseInformation(const NodeNumbers& numbers) : numbers_(numbers) {}

  int NodeOf(const BlockRef& block) const { return numbers_.Of(block); }
  /// Adds `block` at (row, column), or its transpose where that is the lower half. A diagonal block
  /// is taken as it is.
  void Add(int row, int column, const NodeBlock& block);
  /// The block of one pose; zero where there is none.
  Matrix6d Diagonal(int pose) const;
  /// The block of two nodes, row <= column; null where there is none.
  const NodeBlock* Find(int row, int column) const;
  std::size_t count() const { return blocks_.size(); }  ///< of blocks
  /// function(row, column, block) for all blocks, by rows and then columns.
  template <typename Function>
  void ForEach(const Function& function) const {
    for (int row = 0; row < static_cast<int>(rows_.size()); ++row) {
      for (const auto& [column, place] : rows_[row]) function(row, column, blocks_[place]);
    }
  }

 private:
  using Entry = std::pair<int, std::size_t>;  // column, place in blocks_

  NodeNumbers numbers_;
  std::vector<std::vector<Entry>> rows_;  // by column: a map's nodes would be slow to search
  std::vector<NodeBlock> blocks_;
};

/// A factor of poses, maps or scales, linearized: its Jacobians by the world perturbations of its
/// nodes.
struct LinearizedPoseFactor {
  ResidualTag tag;
  std::vector<BlockRef> blocks;
  std::vector<Eigen::MatrixXd> jacobians;
};

/// Adds the information of residuals that all belong to one plane (linearized), the plane
/// eliminated by Schur's complement: H_pp - H_pl H_ll^+ H_lp.
struct PlaneResidual {
  std::vector<BlockRef> blocks;
  ResidualTag tag;
  LinearizedResidual linear;
  Eigen::VectorXd curvature;  ///< what ApplyLossCurvature took the Jacobians' rows times; empty: 1
  Eigen::VectorXd scatter;    ///< variance of what stands for each row in the scores; empty: 1
};
void AddPlaneInformation(const std::vector<const PlaneResidual*>& residuals, double weight,
                         PoseInformation* information);

/// The same for planes that factors tie to each other: all of them are eliminated together.
void AddPlaneGroupInformation(const std::vector<const PlaneResidual*>& residuals,
                              PoseInformation* information);

/// The scatter of the same planes' scores: the sum over residuals of X^T F X, with X the Jacobian
/// by the nodes, the planes eliminated, and F the residual's scatter.
void AddPlaneGroupScatter(const std::vector<const PlaneResidual*>& residuals,
                          PoseInformation* scatter);

/// The linearized residuals of each plane of the graph, of what ties planes, and of its pose
/// factors.
struct LinearizedGraph {
  std::vector<std::vector<PlaneResidual>> planes;
  std::vector<PlaneResidual> plane_factors;
  std::vector<LinearizedPoseFactor> pose_factors;
};
LinearizedGraph LinearizeGraph(const Graph& graph, const SolveOptions& options);

/// The planes that are eliminated together: each by itself, or as plane factors tie them. Points
/// into the linearized graph, which has to live as long.
class PlaneGroups {
 public:
  explicit PlaneGroups(const LinearizedGraph& linear);
  /// All residuals of a plane and of those that are tied to it, the factors between them first.
  std::vector<const PlaneResidual*> Residuals(int plane) const;
  bool IsFirst(int plane) const;  ///< of its group
  bool IsTied(int plane) const;

 private:
  const LinearizedGraph& linear_;
  std::vector<std::size_t> group_;                       // of each plane, its first plane
  std::vector<std::vector<std::size_t>> planes_, ties_;  // of each group, by its first plane
};

/// What a plane (its tangent: two of the normal, the offset) is, given the nodes that see it.
struct PlaneElimination {
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();  ///< with all nodes held
  bool determined = false;
  /// How it moves with each node: 3 x 6, or 3 x 7 of a map.
  std::vector<std::pair<int, Eigen::MatrixXd>> by_nodes;
  /// Its covariance with the scores of each node; zero where no residual has a scatter of its own.
  std::vector<std::pair<int, Eigen::MatrixXd>> with_scores;
};
/// `residuals`: those of its group.
PlaneElimination EliminatePlane(const std::vector<const PlaneResidual*>& residuals,
                                const PoseInformation& nodes, int plane);

/// Adds the information of all planes, in groups where plane factors tie them.
void AddAllPlaneInformation(const LinearizedGraph& linear, PoseInformation* information);
void AddPoseFactorInformation(const LinearizedPoseFactor& factor, PoseInformation* information);

}  // namespace planegraph
