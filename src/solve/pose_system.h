#pragma once

#include <Eigen/SparseCholesky>
#include <Eigen/SparseCore>
#include <memory>
#include <vector>

#include "solve/information.h"

namespace planegraph {

/// The information of the poses that are not held by the gauge, factorized. It may be singular:
/// each pose's translation and rotation are scaled to unit mean information, and kRidge is added to
/// the diagonal, so that a null direction appears with a variance near 1 / kRidge (scaled) while
/// all others keep their digits.
class PoseSystem {
 public:
  PoseSystem(const PoseInformation& information, const Gauge& gauge);

  bool Fixed(int pose) const { return place_[pose] < 0; }
  /// Solves information * x = rhs. Rows of both: 6 per pose of the graph, then 7 per map, zero for
  /// what the gauge holds.
  Eigen::MatrixXd Solve(const Eigen::MatrixXd& rhs) const;
  /// The variance (m^2 for the translation, rad^2 for the rotation) from which a direction of the
  /// pose counts as not observed at all.
  double InfiniteVariance(int pose, bool rotation) const;
  int rows() const { return first_row_.back(); }

 private:
  void SetScale(const PoseInformation& information);
  void Factorize(const PoseInformation& information);

  int Dimension(std::size_t node) const { return first_row_[node + 1] - first_row_[node]; }

  std::vector<int> first_row_;  // of each node among all, and their end
  std::vector<int> place_;      // first row of a node among those that are free, or -1
  Eigen::VectorXd scale_;       // over the free nodes
  Eigen::SimplicialLLT<Eigen::SparseMatrix<double>> cholesky_;
};

}  // namespace planegraph
