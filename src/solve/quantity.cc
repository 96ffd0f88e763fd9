#include "solve/quantity.h"

#include <algorithm>
#include <limits>
#include <map>

namespace planegraph {

using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

// Digits that may be lost when large blocks of the inverse leave a small difference.
constexpr double kLost = 1e8;

const std::string& SourceOf(const Graph& graph, const LinearizedPoseFactor& factor) {
  return factor.tag.map_factor >= 0 ? graph.map_factors[factor.tag.map_factor].source
                                    : graph.pose_factors[factor.tag.pose_factor].source;
}

}  // namespace

MatrixXd Gradient(const PoseSystem& system, const Quantity& quantity) {
  MatrixXd gradient = MatrixXd::Zero(system.rows(), quantity.front().second.rows());
  for (const auto& [node, derivative] : quantity) {
    gradient.middleRows(system.FirstRow(node), system.Dimension(node)) += derivative.transpose();
  }
  return gradient;
}

MatrixXd CovarianceOf(const PoseSystem& system, const Quantity& quantity) {
  const Eigen::Index rows = quantity.front().second.rows();
  MatrixXd covariance = MatrixXd::Zero(rows, rows);
  VectorXd largest = VectorXd::Zero(rows);
  for (const auto& [a, by_a] : quantity) {
    for (const auto& [b, by_b] : quantity) {
      const MatrixXd term = by_a * system.Covariance(a, b) * by_b.transpose();
      covariance += term;
      largest = largest.cwiseMax(term.diagonal().cwiseAbs());
    }
  }
  // What moves together without a hold: by solving for the quantity itself.
  if ((largest.array() > kLost * covariance.diagonal().array()).any()) {
    covariance = system.CovarianceOf(Gradient(system, quantity));
  }
  return 0.5 * (covariance + covariance.transpose());
}

double InfiniteVariance(const PoseSystem& system, const Quantity& quantity, bool rotation) {
  double limit = std::numeric_limits<double>::infinity();
  for (const auto& [node, derivative] : quantity) {
    limit = std::min(limit, system.InfiniteVariance(node, rotation ? 3 : 0));
  }
  return limit;
}

bool TiesMaps(const Graph& graph, const LinearizedPoseFactor& factor) {
  return factor.tag.map_factor >= 0 && graph.map_factors[factor.tag.map_factor].maps.size() == 2;
}

// The variance g^T H^-1 g is x^T H x with x = H^-1 g, and H is the sum of its factors: each has its
// share in holding the direction.
std::string HolderOf(const Graph& graph, const LinearizedGraph& linear, const PoseSystem& system,
                     const VectorXd& response) {
  const NodeNumbers numbers(graph);
  std::map<std::string, double> shares;
  for (const LinearizedPoseFactor& factor : linear.pose_factors) {
    if (TiesMaps(graph, factor)) continue;  // it holds a map's shape, not its place
    VectorXd moved = VectorXd::Zero(factor.jacobians[0].rows());
    for (std::size_t k = 0; k < factor.blocks.size(); ++k) {
      const int node = numbers.Of(factor.blocks[k]);
      moved +=
          factor.jacobians[k] * response.segment(system.FirstRow(node), factor.jacobians[k].cols());
    }
    shares[SourceOf(graph, factor)] += moved.squaredNorm();
  }
  std::string holder;
  double best = 0.0;
  for (const auto& [source, share] : shares) {
    if (share > best) holder = source, best = share;
  }
  return holder;
}

}  // namespace planegraph
