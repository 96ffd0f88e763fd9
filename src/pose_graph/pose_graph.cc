#include "planegraph/pose_graph/pose_graph.h"

#include <Eigen/LU>

#include "pose_graph/edge_model.h"

namespace planegraph {

template <int Dim>
double EdgeChi2(const PoseGraph<Dim>& graph, const GraphEdge<Dim>& edge) {
  const auto residual = EdgeResidual<Dim>(graph.poses[edge.from], graph.poses[edge.to], edge,
                                          graph.rotation_residual);
  return residual.dot(edge.information * residual);
}

template <int Dim>
double GraphCost(const PoseGraph<Dim>& graph) {
  double sum = 0.0;
  for (const GraphEdge<Dim>& edge : graph.edges) sum += EdgeChi2(graph, edge);
  return 0.5 * sum;
}

template <>
IsotropicWeights<3> IsotropicWeightsOf<3>(const PoseInformation<3>& information) {
  return {3.0 / information.topLeftCorner<3, 3>().inverse().trace(),
          1.5 / information.bottomRightCorner<3, 3>().inverse().trace()};
}

template <>
IsotropicWeights<2> IsotropicWeightsOf<2>(const PoseInformation<2>& information) {
  return {2.0 / information.topLeftCorner<2, 2>().inverse().trace(), information(2, 2)};
}

template <int Dim>
PoseInformation<Dim> IsotropicInformation(const IsotropicWeights<Dim>& weights) {
  PoseInformation<Dim> information = PoseInformation<Dim>::Identity() * weights.tau;
  constexpr int kRotation = kPoseDimension<Dim> - Dim;
  information.template bottomRightCorner<kRotation, kRotation>().diagonal().setConstant(
      8.0 * weights.kappa);
  return information;
}

template double EdgeChi2<2>(const PoseGraph2&, const GraphEdge<2>&);
template double EdgeChi2<3>(const PoseGraph3&, const GraphEdge<3>&);
template double GraphCost<2>(const PoseGraph2&);
template double GraphCost<3>(const PoseGraph3&);
template PoseInformation<2> IsotropicInformation<2>(const IsotropicWeights<2>&);
template PoseInformation<3> IsotropicInformation<3>(const IsotropicWeights<3>&);

}  // namespace planegraph
