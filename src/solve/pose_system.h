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
  PoseSystem(const PoseInformation& information, const std::vector<bool>& fixed);

  bool Fixed(int pose) const { return place_[pose] < 0; }
  /// Solves information * x = rhs. Rows of both: 6 per pose of the graph, zero for fixed poses.
  Eigen::MatrixXd Solve(const Eigen::MatrixXd& rhs) const;
  /// The variance (m^2 for the translation, rad^2 for the rotation) from which a direction of the
  /// pose counts as not observed at all.
  double InfiniteVariance(int pose, bool rotation) const;
  int rows() const { return 6 * static_cast<int>(place_.size()); }

 private:
  void SetScale(const PoseInformation& information);
  void Factorize(const PoseInformation& information);

  std::vector<int> place_;  // of a pose among those that are free, or -1
  Eigen::VectorXd scale_;   // over the free poses
  Eigen::SimplicialLLT<Eigen::SparseMatrix<double>> cholesky_;
};

}  // namespace planegraph
