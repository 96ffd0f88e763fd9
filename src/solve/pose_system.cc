#include "solve/pose_system.h"

#include <Eigen/OrderingMethods>
#include <cmath>

#include "planegraph/base/error.h"

namespace planegraph {
namespace {

using Eigen::MatrixXd;

// Rounding leaves about 1e-15 in a null direction of the scaled information.
constexpr double kRidge = 1e-12;
// Scaled variance of a direction that counts as not observed: its sigma is 3e4 times what the
// scan's own planes would give with all other poses held.
constexpr double kInfinite = 1e9;

double UnitScale(double trace) { return trace > 0.0 ? 1.0 / std::sqrt(trace / 3.0) : 1.0; }

// The nodes in an order with little fill. Those that are held come too; they do no harm.
std::vector<int> EliminationOrder(const PoseInformation& information, int nodes) {
  std::vector<Eigen::Triplet<double>> triplets;
  for (const auto& [key, block] : information.blocks()) {
    triplets.emplace_back(key.first, key.second, 1.0);
    triplets.emplace_back(key.second, key.first, 1.0);
  }
  for (int k = 0; k < nodes; ++k) triplets.emplace_back(k, k, 1.0);
  Eigen::SparseMatrix<double> pattern(nodes, nodes);
  pattern.setFromTriplets(triplets.begin(), triplets.end());
  Eigen::PermutationMatrix<Eigen::Dynamic, Eigen::Dynamic, int> order;
  Eigen::AMDOrdering<int>()(pattern, order);
  return {order.indices().data(), order.indices().data() + nodes};
}

}  // namespace

PoseSystem::PoseSystem(const PoseInformation& information, const Gauge& gauge) : first_row_{0} {
  PlaceNodes(information, gauge);
  scale_.setOnes(starts_.back());
  SetScale(information);
  if (starts_.back() == 0) return;
  Factorize(information);
  inverse_ = std::make_unique<SelectedInverse>(cholesky_.matrixL().nestedExpression(), starts_);
}

void PoseSystem::PlaceNodes(const PoseInformation& information, const Gauge& gauge) {
  std::vector<bool> fixed = gauge.poses;
  fixed.insert(fixed.end(), gauge.maps.begin(), gauge.maps.end());
  for (std::size_t k = 0; k < fixed.size(); ++k) {
    const int dimension = k < gauge.poses.size() ? kPoseTangent : kMapTangent;
    first_row_.push_back(first_row_.back() + dimension);
  }
  const int nodes = static_cast<int>(fixed.size());
  place_.assign(fixed.size(), -1);
  rank_.assign(fixed.size(), -1);
  starts_ = {0};
  for (const int node : EliminationOrder(information, nodes)) {
    if (fixed[node]) continue;
    rank_[node] = static_cast<int>(starts_.size()) - 1;
    place_[node] = starts_.back();
    starts_.push_back(starts_.back() + Dimension(node));
  }
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
  triplets.reserve(49 * information.blocks().size() + scale_.size());
  for (const auto& [key, block] : information.blocks()) {
    const int row = place_[key.first], column = place_[key.second];
    if (row < 0 || column < 0) continue;
    for (int a = 0; a < block.rows(); ++a) {
      for (int b = key.first == key.second ? a : 0; b < block.cols(); ++b) {
        // The lower half, which is what the factorization reads.
        triplets.emplace_back(std::max(row + a, column + b), std::min(row + a, column + b),
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

MatrixXd PoseSystem::Solve(const MatrixXd& rhs) const {
  MatrixXd result = MatrixXd::Zero(rows(), rhs.cols());
  if (scale_.size() == 0) return result;
  MatrixXd reduced(scale_.size(), rhs.cols());
  for (int node = 0; node < static_cast<int>(place_.size()); ++node) {
    if (place_[node] < 0) continue;
    reduced.middleRows(place_[node], Dimension(node)) =
        rhs.middleRows(first_row_[node], Dimension(node));
  }
  reduced = scale_.asDiagonal() * cholesky_.solve(scale_.asDiagonal() * reduced).eval();
  for (int node = 0; node < static_cast<int>(place_.size()); ++node) {
    if (place_[node] < 0) continue;
    result.middleRows(first_row_[node], Dimension(node)) =
        reduced.middleRows(place_[node], Dimension(node));
  }
  return result;
}

MatrixXd PoseSystem::Block(int row, int column) const {
  const int rows = Dimension(row), columns = Dimension(column);
  if (place_[row] < 0 || place_[column] < 0) return MatrixXd::Zero(rows, columns);
  if (inverse_->Has(std::max(rank_[row], rank_[column]), std::min(rank_[row], rank_[column]))) {
    return scale_.segment(place_[row], rows).asDiagonal() *
           inverse_->Block(rank_[row], rank_[column]) *
           scale_.segment(place_[column], columns).asDiagonal();
  }
  MatrixXd unit = MatrixXd::Zero(this->rows(), columns);
  unit.middleRows(first_row_[column], columns).setIdentity();
  return Solve(unit).middleRows(first_row_[row], rows);
}

double PoseSystem::InfiniteVariance(int node, bool rotation) const {
  if (place_[node] < 0) return INFINITY;
  const double scale = scale_[place_[node] + (rotation ? 3 : 0)];
  return kInfinite * scale * scale;
}

}  // namespace planegraph
