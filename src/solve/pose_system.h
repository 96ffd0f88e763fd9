#pragma once

#include <Eigen/SparseCore>
#include <memory>
#include <vector>

#include "solve/information.h"
#include "solve/selected_inverse.h"

namespace planegraph {

/// The information of the poses that are not held by the gauge, factorized. It may be singular:
/// each pose's translation and rotation are scaled to unit mean information, and kRidge is added to
/// the diagonal, so that a null direction appears with a variance near 1 / kRidge (scaled) while
/// all others keep their digits.
class PoseSystem {
 public:
  PoseSystem(const PoseInformation& information, const Gauge& gauge);

  bool Fixed(int pose) const { return place_[pose] < 0; }
  /// Solves information * x = rhs. Rows of both: 6 per pose of the graph, then 7 per map, then 1
  /// per scale; zero for what the gauge holds.
  Eigen::MatrixXd Solve(const Eigen::MatrixXd& rhs) const;
  /// The block of information^-1 of two nodes, zero where the gauge holds one.
  /// At no cost where they have a plane or a factor in common, or where the elimination has tied
  /// them.
  NodeBlock Block(int row, int column) const;
  /// From now on covariances are information^-1 scatter information^-1 (of an M-estimator, Huber
  /// 1967), for a scatter of the scores with no other blocks than the information. Without it they
  /// are information^-1.
  void SetScatter(const PoseInformation& scatter);
  /// The covariance between two nodes, as cheap as Block.
  NodeBlock Covariance(int row, int column) const;
  /// The covariance of quantities by their gradients, one a column.
  Eigen::MatrixXd CovarianceOf(const Eigen::MatrixXd& gradients) const;
  /// The variance (m^2 of a translation, rad^2 of a rotation, by the row) from which a direction of
  /// the node counts as not observed at all.
  double InfiniteVariance(int node, int row) const;
  int rows() const { return first_row_.back(); }
  int FirstRow(int node) const { return first_row_[node]; }
  int Dimension(int node) const { return first_row_[node + 1] - first_row_[node]; }

 private:
  void PlaceNodes(const PoseInformation& information, const Gauge& gauge);
  void SetScale(const PoseInformation& information);
  void Factorize(const PoseInformation& information);
  Eigen::SparseMatrix<double> Scaled(const PoseInformation& information) const;
  Eigen::MatrixXd Reduced(const Eigen::MatrixXd& all) const;
  NodeBlock Unscaled(int row, int column, const NodeBlock& block) const;

  std::vector<int> first_row_;  // of each node among all, and their end
  std::vector<int> rank_;       // of a node in the order of elimination, or -1
  std::vector<int> place_;      // its first row in that order, or -1
  std::vector<int> starts_;     // the first row of each rank, and their end
  Eigen::VectorXd scale_;       // over the free nodes, in that order
  std::unique_ptr<FactorStructure> structure_;
  std::unique_ptr<BlockFactor> factor_;
  std::unique_ptr<SelectedInverse> inverse_;
  Eigen::SparseMatrix<double> scatter_;  // lower half, scaled; empty: the information
  std::unique_ptr<SelectedSandwich> covariance_;
};

}  // namespace planegraph
