#include "planegraph/pose_graph/optimization.h"

#include <chrono>
#include <stdexcept>

#include "pose_graph/optimizer.h"

namespace planegraph {
namespace {

template <int Dim>
void Check(const PoseGraph<Dim>& graph, const PoseGraphOptions& options) {
  if (!options.weights.empty() && options.weights.size() != graph.edges.size()) {
    throw std::invalid_argument("one weight for each edge is needed");
  }
  CheckIndices(graph);
}

}  // namespace

template <int Dim>
PoseGraphSummary OptimizePoseGraph(PoseGraph<Dim>* graph, const PoseGraphOptions& options) {
  const auto start = std::chrono::steady_clock::now();
  Check(*graph, options);
  PoseGraphSummary summary = Optimizer<Dim>(graph, &options).Run();
  summary.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  return summary;
}

template PoseGraphSummary OptimizePoseGraph<2>(PoseGraph2*, const PoseGraphOptions&);
template PoseGraphSummary OptimizePoseGraph<3>(PoseGraph3*, const PoseGraphOptions&);

}  // namespace planegraph
