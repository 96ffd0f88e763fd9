#pragma once

#include <utility>
#include <vector>

#include "planegraph/pose_graph/optimization.h"

namespace planegraph {

/// (from, to) of each edge, in their order: the k-th pair of the pattern is the k-th edge.
template <int Dim>
std::vector<std::pair<int, int>> PairsOf(const PoseGraph<Dim>& graph) {
  std::vector<std::pair<int, int>> pairs;
  pairs.reserve(graph.edges.size());
  for (const GraphEdge<Dim>& edge : graph.edges) pairs.emplace_back(edge.from, edge.to);
  return pairs;
}

/// Throws std::invalid_argument.
template <int Dim>
void CheckIndices(const PoseGraph<Dim>& graph);

}  // namespace planegraph
