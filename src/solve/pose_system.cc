#include "solve/pose_system.h"

#include <cmath>

#include "planegraph/base/error.h"

namespace planegraph {
namespace {

// Rounding leaves about 1e-15 in a null direction of the scaled information.
constexpr double kRidge = 1e-12;
// Scaled variance of a direction that counts as not observed: its sigma is 3e4 times what the
// scan's own planes would give with all other poses held.
constexpr double kInfinite = 1e9;

double UnitScale(double trace) { return trace > 0.0 ? 1.0 / std::sqrt(trace / 3.0) : 1.0; }

}  // namespace

PoseSystem::PoseSystem(const PoseInformation& information, const Gauge& gauge) : first_row_{0} {
  int free = 0;
  const auto add_node = [&](int dimension, bool fixed) {
    place_.push_back(fixed ? -1 : free);
    free += fixed ? 0 : dimension;
    first_row_.push_back(first_row_.back() + dimension);
  };
  for (const bool fixed : gauge.poses) add_node(kPoseTangent, fixed);
  for (const bool fixed : gauge.maps) add_node(kMapTangent, fixed);
  scale_.setOnes(free);
  SetScale(information);
  if (free > 0) Factorize(information);
}

void PoseSystem::SetScale(const PoseInformation& information) {
  for (const auto& [key, block] : information.blocks()) {
    const int at = place_[key.first];
    if (key.first != key.second || at < 0) continue;
    const Eigen::VectorXd diagonal = block.diagonal();
    scale_.segment<3>(at).setConstant(UnitScale(diagonal.head<3>().sum()));
    scale_.segment<3>(at + 3).setConstant(UnitScale(diagonal.segment<3>(3).sum()));
    if (diagonal.size() > 6) scale_[at + 6] = UnitScale(3.0 * diagonal[6]);
  }
}

void PoseSystem::Factorize(const PoseInformation& information) {
  std::vector<Eigen::Triplet<double>> triplets;
  triplets.reserve(36 * information.blocks().size() + scale_.size());
  for (const auto& [key, block] : information.blocks()) {
    const int row = place_[key.first], column = place_[key.second];
    if (row < 0 || column < 0) continue;
    for (int a = 0; a < block.rows(); ++a) {
      for (int b = key.first == key.second ? a : 0; b < block.cols(); ++b) {
        // The lower half, which is what the factorization reads; places keep the nodes' order.
        triplets.emplace_back(column + b, row + a,
                              scale_[row + a] * block(a, b) * scale_[column + b]);
      }
    }
  }
  for (int k = 0; k < scale_.size(); ++k) triplets.emplace_back(k, k, kRidge);
  Eigen::SparseMatrix<double> matrix(scale_.size(), scale_.size());
  matrix.setFromTriplets(triplets.begin(), triplets.end());
  cholesky_.compute(matrix);
  if (cholesky_.info() != Eigen::Success) {
    throw NoResultError("no covariance: the information of the poses is not positive");
  }
}

Eigen::MatrixXd PoseSystem::Solve(const Eigen::MatrixXd& rhs) const {
  Eigen::MatrixXd result = Eigen::MatrixXd::Zero(rows(), rhs.cols());
  if (scale_.size() == 0) return result;
  Eigen::MatrixXd reduced(scale_.size(), rhs.cols());
  for (std::size_t i = 0; i < place_.size(); ++i) {
    if (place_[i] < 0) continue;
    reduced.middleRows(place_[i], Dimension(i)) = rhs.middleRows(first_row_[i], Dimension(i));
  }
  reduced = scale_.asDiagonal() * cholesky_.solve(scale_.asDiagonal() * reduced).eval();
  for (std::size_t i = 0; i < place_.size(); ++i) {
    if (place_[i] < 0) continue;
    result.middleRows(first_row_[i], Dimension(i)) = reduced.middleRows(place_[i], Dimension(i));
  }
  return result;
}

double PoseSystem::InfiniteVariance(int pose, bool rotation) const {
  if (place_[pose] < 0) return INFINITY;
  const double scale = scale_[place_[pose] + (rotation ? 3 : 0)];
  return kInfinite * scale * scale;
}

}  // namespace planegraph
