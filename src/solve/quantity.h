#pragma once

#include <Eigen/Core>
#include <string>
#include <utility>
#include <vector>

#include "solve/pose_system.h"

namespace planegraph {

/// A quantity that is linear in the perturbations of nodes: its derivative by each of them. Of more
/// than three rows, the first three of six are a translation, the others a rotation.
using Quantity = std::vector<std::pair<int, Eigen::MatrixXd>>;

/// Its derivatives, transposed, in the rows of all nodes.
Eigen::MatrixXd Gradient(const PoseSystem& system, const Quantity& quantity);

/// Its covariance.
Eigen::MatrixXd CovarianceOf(const PoseSystem& system, const Quantity& quantity);

/// The variance from which a direction of it is infinite: the least one of its nodes.
double InfiniteVariance(const PoseSystem& system, const Quantity& quantity, bool rotation);

/// Whether a factor ties two maps to each other.
bool TiesMaps(const Graph& graph, const LinearizedPoseFactor& factor);

/// What holds a direction with gradient g most, by its response H^-1 g: the `source` of a factor of
/// poses or maps.
std::string HolderOf(const Graph& graph, const LinearizedGraph& linear, const PoseSystem& system,
                     const Eigen::VectorXd& response);

}  // namespace planegraph
