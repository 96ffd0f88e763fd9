#include "solve/pose_system.h"

#include <Eigen/OrderingMethods>
#include <algorithm>
#include <cmath>
#include <utility>

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
  information.ForEach([&](int row, int column, const NodeBlock&) {
    triplets.emplace_back(row, column, 1.0);
    triplets.emplace_back(column, row, 1.0);
  });
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
  inverse_ = std::make_unique<SelectedInverse>(*factor_);
}

void PoseSystem::PlaceNodes(const PoseInformation& information, const Gauge& gauge) {
  std::vector<bool> fixed = gauge.poses;
  fixed.insert(fixed.end(), gauge.maps.begin(), gauge.maps.end());
  fixed.insert(fixed.end(), gauge.scales.begin(), gauge.scales.end());
  const auto place = [&](std::size_t count, int dimension) {
    for (; count > 0; --count) first_row_.push_back(first_row_.back() + dimension);
  };
  place(gauge.poses.size(), kPoseTangent);
  place(gauge.maps.size(), kMapTangent);
  place(gauge.scales.size(), 1);
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
  for (int node = 0; node < static_cast<int>(place_.size()); ++node) {
    const int at = place_[node];
    const NodeBlock* block = information.Find(node, node);
    if (block == nullptr || at < 0) continue;
    const Eigen::VectorXd diagonal = block->diagonal();
    if (diagonal.size() == 1) {
      scale_[at] = UnitScale(3.0 * diagonal[0]);
      continue;
    }
    scale_.segment<3>(at).setConstant(UnitScale(diagonal.head<3>().sum()));
    scale_.segment<3>(at + 3).setConstant(UnitScale(diagonal.segment<3>(3).sum()));
    if (diagonal.size() > 6) scale_[at + 6] = UnitScale(3.0 * diagonal[6]);
  }
}

void PoseSystem::Factorize(const PoseInformation& information) {
  std::vector<std::vector<int>> below(starts_.size() - 1);
  information.ForEach([&](int row, int column, const NodeBlock&) {
    const auto [low, high] = std::minmax(rank_[row], rank_[column]);
    if (low >= 0 && low < high) below[low].push_back(high);
  });
  structure_ = std::make_unique<FactorStructure>(starts_, std::move(below));
  factor_ = std::make_unique<BlockFactor>(*structure_);
  if (!factor_->Factorize(Scaled(information))) {
    throw NoResultError("no covariance: the information of the poses is not positive");
  }
}

// The lower half, which is what the factorization reads, with the ridge.
Eigen::SparseMatrix<double> PoseSystem::Scaled(const PoseInformation& information) const {
  std::vector<Eigen::Triplet<double>> triplets;
  triplets.reserve(49 * information.count() + scale_.size());
  information.ForEach([&](int first, int second, const NodeBlock& block) {
    const int row = place_[first], column = place_[second];
    if (row < 0 || column < 0) return;
    for (int a = 0; a < block.rows(); ++a) {
      for (int b = first == second ? a : 0; b < block.cols(); ++b) {
        triplets.emplace_back(std::max(row + a, column + b), std::min(row + a, column + b),
                              scale_[row + a] * block(a, b) * scale_[column + b]);
      }
    }
  });
  for (int k = 0; k < scale_.size(); ++k) triplets.emplace_back(k, k, kRidge);
  Eigen::SparseMatrix<double> matrix(scale_.size(), scale_.size());
  matrix.setFromTriplets(triplets.begin(), triplets.end());
  return matrix;
}

// The rows of the nodes that are free, in the order of elimination.
MatrixXd PoseSystem::Reduced(const MatrixXd& all) const {
  MatrixXd reduced(scale_.size(), all.cols());
  for (int node = 0; node < static_cast<int>(place_.size()); ++node) {
    if (place_[node] < 0) continue;
    reduced.middleRows(place_[node], Dimension(node)) =
        all.middleRows(first_row_[node], Dimension(node));
  }
  return reduced;
}

MatrixXd PoseSystem::Solve(const MatrixXd& rhs) const {
  MatrixXd result = MatrixXd::Zero(rows(), rhs.cols());
  if (scale_.size() == 0) return result;
  const MatrixXd reduced =
      scale_.asDiagonal() * factor_->Solve(scale_.asDiagonal() * Reduced(rhs)).eval();
  for (int node = 0; node < static_cast<int>(place_.size()); ++node) {
    if (place_[node] < 0) continue;
    result.middleRows(first_row_[node], Dimension(node)) =
        reduced.middleRows(place_[node], Dimension(node));
  }
  return result;
}

NodeBlock PoseSystem::Unscaled(int row, int column, const NodeBlock& block) const {
  return scale_.segment(place_[row], Dimension(row)).asDiagonal() * block *
         scale_.segment(place_[column], Dimension(column)).asDiagonal();
}

NodeBlock PoseSystem::Block(int row, int column) const {
  const int rows = Dimension(row), columns = Dimension(column);
  if (place_[row] < 0 || place_[column] < 0) return NodeBlock::Zero(rows, columns);
  if (inverse_->Has(std::max(rank_[row], rank_[column]), std::min(rank_[row], rank_[column]))) {
    return Unscaled(row, column, inverse_->Block(rank_[row], rank_[column]));
  }
  MatrixXd unit = MatrixXd::Zero(this->rows(), columns);
  unit.middleRows(first_row_[column], columns).setIdentity();
  return Solve(unit).middleRows(first_row_[row], rows);
}

void PoseSystem::SetScatter(const PoseInformation& scatter) {
  if (scale_.size() == 0) return;
  // The ridge comes in, too: as a prior of its own, so that open directions stay what they are.
  scatter_ = Scaled(scatter);
  covariance_ = std::make_unique<SelectedSandwich>(*factor_, scatter_, *inverse_);
}

NodeBlock PoseSystem::Covariance(int row, int column) const {
  if (!covariance_ || place_[row] < 0 || place_[column] < 0) return Block(row, column);
  if (inverse_->Has(std::max(rank_[row], rank_[column]), std::min(rank_[row], rank_[column]))) {
    return Unscaled(row, column, covariance_->Block(rank_[row], rank_[column]));
  }
  MatrixXd unit = MatrixXd::Zero(rows(), Dimension(row) + Dimension(column));
  unit.block(first_row_[row], 0, Dimension(row), Dimension(row)).setIdentity();
  unit.bottomRightCorner(rows() - first_row_[column], Dimension(column))
      .topRows(Dimension(column))
      .setIdentity();
  return CovarianceOf(unit).topRightCorner(Dimension(row), Dimension(column));
}

MatrixXd PoseSystem::CovarianceOf(const MatrixXd& gradients) const {
  if (!covariance_) return gradients.transpose() * Solve(gradients);
  const MatrixXd response = factor_->Solve(scale_.asDiagonal() * Reduced(gradients));
  return response.transpose() * (scatter_.selfadjointView<Eigen::Lower>() * response);
}

double PoseSystem::InfiniteVariance(int node, int row) const {
  if (place_[node] < 0) return INFINITY;
  const double scale = scale_[place_[node] + row];
  return kInfinite * scale * scale;
}

}  // namespace planegraph
