#pragma once

#include <map>
#include <utility>
#include <vector>

#include "solve/assembly.h"

namespace planegraph {

/// A symmetric matrix of 6x6 blocks over the poses, upper blocks (row <= column) only.
class PoseInformation {
 public:
  /// Adds `block` at (row, column), or its transpose where that is the lower half. A diagonal block
  /// is taken as it is.
  void Add(int row, int column, const Matrix6d& block);
  void Add(const PoseInformation& other);
  /// The block of one pose; zero where there is none.
  Matrix6d Diagonal(int pose) const;
  const std::map<std::pair<int, int>, Matrix6d>& blocks() const { return blocks_; }

 private:
  std::map<std::pair<int, int>, Matrix6d> blocks_;
};

/// A pose factor, linearized: its Jacobians by the world perturbations of its poses.
struct LinearizedPoseFactor {
  int index = 0;  ///< in Graph::pose_factors
  std::array<int, 2> poses{-1, -1};
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
