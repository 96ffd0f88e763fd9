#include "pose_graph/gauge.h"

#include <stdexcept>

#include "planegraph/base/disjoint_sets.h"

namespace planegraph {
template <int Dim>
void CheckIndices(const PoseGraph<Dim>& graph) {
  const int count = static_cast<int>(graph.poses.size());
  if (graph.fixed.size() != graph.poses.size()) {
    throw std::invalid_argument("one `fixed` for each pose is needed");
  }
  for (const GraphEdge<Dim>& edge : graph.edges) {
    const bool inside = edge.from >= 0 && edge.to >= 0 && edge.from < count && edge.to < count;
    if (!inside || edge.from == edge.to) {
      throw std::invalid_argument("an edge does not join two poses of the graph");
    }
  }
}

template <int Dim>
std::vector<int> ConnectedParts(const PoseGraph<Dim>& graph) {
  DisjointSets sets(graph.poses.size());
  for (const GraphEdge<Dim>& edge : graph.edges) {
    sets.Join(static_cast<std::size_t>(edge.from), static_cast<std::size_t>(edge.to));
  }
  std::vector<int> parts;
  for (std::size_t i = 0; i < graph.poses.size(); ++i) {
    parts.push_back(static_cast<int>(sets.Find(i)));
  }
  return parts;
}

template <int Dim>
std::vector<bool> GaugeOf(const PoseGraph<Dim>& graph) {
  const std::vector<int> parts = ConnectedParts(graph);
  std::vector<bool> held = graph.fixed, has_fixed(parts.size(), false);
  for (std::size_t i = 0; i < parts.size(); ++i) {
    if (held[i]) has_fixed[parts[i]] = true;
  }
  for (std::size_t i = 0; i < parts.size(); ++i) {
    if (!has_fixed[parts[i]]) held[parts[i]] = true;
  }
  return held;
}

template void CheckIndices<2>(const PoseGraph2&);
template void CheckIndices<3>(const PoseGraph3&);
template std::vector<int> ConnectedParts<2>(const PoseGraph2&);
template std::vector<int> ConnectedParts<3>(const PoseGraph3&);
template std::vector<bool> GaugeOf<2>(const PoseGraph2&);
template std::vector<bool> GaugeOf<3>(const PoseGraph3&);

}  // namespace planegraph
