#pragma once

#include <stdexcept>
#include <vector>

#include "planegraph/pose_graph/pose_graph.h"

namespace planegraph {

/// The isotropic problem as a quadratic form: F = tr(X M X^T) over X_i = [R_i t_i], M symmetric
/// with a (Dim + 1)-block for each pose and each edge (SE-Sync's data matrix with the translations
/// kept).
template <int Dim>
struct ConnectionBlocks {
  using Block = Eigen::Matrix<double, Dim + 1, Dim + 1>;

  std::vector<Block> diagonal;  ///< of each pose
  std::vector<Block> cross;     ///< of each edge: rows its `from`, columns its `to`

  /// Throws std::invalid_argument where an information is not IsotropicInformation().
  explicit ConnectionBlocks(const PoseGraph<Dim>& graph) {
    diagonal.assign(graph.poses.size(), Block::Zero());
    cross.reserve(graph.edges.size());
    for (const GraphEdge<Dim>& edge : graph.edges) Add(edge);
  }

 private:
  static IsotropicWeights<Dim> WeightsIn(const GraphEdge<Dim>& edge) {
    const int last = kPoseDimension<Dim> - 1;
    const IsotropicWeights<Dim> weights{edge.information(0, 0), edge.information(last, last) / 8.0};
    const PoseInformation<Dim> difference = edge.information - IsotropicInformation<Dim>(weights);
    if (!(difference.norm() <= 1e-12 * edge.information.norm())) {
      throw std::invalid_argument("the certificate needs isotropic weights");
    }
    return weights;
  }

  void Add(const GraphEdge<Dim>& edge) {
    const auto [tau, kappa] = WeightsIn(edge);
    const Eigen::Matrix<double, Dim, 1>& z = edge.measurement.translation;
    Block from = Block::Zero(), to = Block::Zero(), between = Block::Zero();
    from.template topLeftCorner<Dim, Dim>() =
        kappa * Eigen::Matrix<double, Dim, Dim>::Identity() + tau * z * z.transpose();
    from.template topRightCorner<Dim, 1>() = tau * z;
    from.template bottomLeftCorner<1, Dim>() = tau * z.transpose();
    from(Dim, Dim) = to(Dim, Dim) = tau;
    to.diagonal().template head<Dim>().setConstant(kappa);
    between.template topLeftCorner<Dim, Dim>() = -kappa * edge.measurement.rotation;
    between.template topRightCorner<Dim, 1>() = -tau * z;
    between(Dim, Dim) = -tau;
    diagonal[edge.from] += from;
    diagonal[edge.to] += to;
    cross.push_back(between);
  }
};

}  // namespace planegraph
