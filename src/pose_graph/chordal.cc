#include "pose_graph/block_cholesky.h"
#include "pose_graph/edge_model.h"
#include "pose_graph/gauge.h"

namespace planegraph {
namespace {

using Eigen::MatrixXd;

template <int Dim>
std::vector<IsotropicWeights<Dim>> WeightsOf(const PoseGraph<Dim>& graph) {
  std::vector<IsotropicWeights<Dim>> weights;
  weights.reserve(graph.edges.size());
  for (const GraphEdge<Dim>& edge : graph.edges) {
    IsotropicWeights<Dim> w = IsotropicWeightsOf<Dim>(edge.information);
    // An information that knows nothing of one direction gives no weight, and the edge is all the
    // same better than none.
    if (!(w.tau > 0.0)) w.tau = 1e-12;
    if (!(w.kappa > 0.0)) w.kappa = 1e-12;
    weights.push_back(w);
  }
  return weights;
}

// Least squares over X_i (rows of `right`, one block row a pose) of weight |X_to - M X_from|^2:
// M is Z^T for rotations (transposed: R_to^T = Z^T R_from^T) and 1 for translations.
template <int K>
class LinearSystem {
 public:
  using Block = Eigen::Matrix<double, K, K>;

  LinearSystem(const BlockPattern& pattern, const std::vector<bool>& held, int columns)
      : held_(held), matrix_(pattern, K), right_(MatrixXd::Zero(held.size() * K, columns)) {}

  void SetHeld(int pose, const Eigen::Ref<const MatrixXd>& value) {
    matrix_.template Diagonal<K>(pose).setIdentity();
    right_.middleRows(pose * K, K) = value;
  }
  // weight |X_to - m X_from - offset|^2 with an orthogonal m.
  void Add(int pair, int from, int to, double weight, const Block& m, const MatrixXd& offset,
           const MatrixXd& held_from, const MatrixXd& held_to) {
    if (!held_[from]) {
      matrix_.template Diagonal<K>(from).diagonal().array() += weight;
      right_.middleRows(from * K, K) -= weight * (m.transpose() * offset);
      if (held_[to]) right_.middleRows(from * K, K) += weight * (m.transpose() * held_to);
    }
    if (!held_[to]) {
      matrix_.template Diagonal<K>(to).diagonal().array() += weight;
      right_.middleRows(to * K, K) += weight * offset;
      if (held_[from]) right_.middleRows(to * K, K) += weight * (m * held_from);
    }
    if (!held_[from] && !held_[to]) {
      matrix_.template AddPair<K>(pair, Block(-weight * m.transpose()));
    }
  }
  bool Solve(MatrixXd* solution) {
    if (!matrix_.Factorize()) return false;
    *solution = matrix_.Solve(right_);
    return true;
  }

 private:
  const std::vector<bool>& held_;
  BlockCholesky matrix_;
  MatrixXd right_;
};

template <int Dim>
void SolveRotations(const BlockPattern& pattern, const std::vector<bool>& held,
                    const std::vector<IsotropicWeights<Dim>>& weights, PoseGraph<Dim>* graph) {
  LinearSystem<Dim> system(pattern, held, Dim);
  std::vector<GraphPose<Dim>>& poses = graph->poses;
  for (std::size_t i = 0; i < poses.size(); ++i) {
    if (held[i]) system.SetHeld(static_cast<int>(i), poses[i].rotation.transpose());
  }
  const MatrixXd zero = MatrixXd::Zero(Dim, Dim);
  for (std::size_t k = 0; k < graph->edges.size(); ++k) {
    const GraphEdge<Dim>& edge = graph->edges[k];
    system.Add(static_cast<int>(k), edge.from, edge.to, weights[k].kappa,
               edge.measurement.rotation.transpose(), zero, poses[edge.from].rotation.transpose(),
               poses[edge.to].rotation.transpose());
  }
  MatrixXd solution;
  if (!system.Solve(&solution)) return;
  for (std::size_t i = 0; i < poses.size(); ++i) {
    if (held[i]) continue;
    const Eigen::Matrix<double, Dim, Dim> block = solution.middleRows(i * Dim, Dim).transpose();
    poses[i].rotation = NearestRotation<Dim>(block);
  }
}

template <int Dim>
void SolveTranslations(const BlockPattern& pattern, const std::vector<bool>& held,
                       const std::vector<IsotropicWeights<Dim>>& weights, PoseGraph<Dim>* graph) {
  LinearSystem<1> system(pattern, held, Dim);
  std::vector<GraphPose<Dim>>& poses = graph->poses;
  for (std::size_t i = 0; i < poses.size(); ++i) {
    if (held[i]) system.SetHeld(static_cast<int>(i), poses[i].translation.transpose());
  }
  const Eigen::Matrix<double, 1, 1> one(1.0);
  for (std::size_t k = 0; k < graph->edges.size(); ++k) {
    const GraphEdge<Dim>& edge = graph->edges[k];
    system.Add(static_cast<int>(k), edge.from, edge.to, weights[k].tau, one,
               (poses[edge.from].rotation * edge.measurement.translation).transpose(),
               poses[edge.from].translation.transpose(), poses[edge.to].translation.transpose());
  }
  MatrixXd solution;
  if (!system.Solve(&solution)) return;
  for (std::size_t i = 0; i < poses.size(); ++i) {
    if (!held[i]) poses[i].translation = solution.row(i).transpose();
  }
}

}  // namespace

template <int Dim>
void InitializeChordal(PoseGraph<Dim>* graph) {
  CheckIndices(*graph);
  const BlockPattern pattern(static_cast<int>(graph->poses.size()), PairsOf(*graph));
  const std::vector<bool> held = GaugeOf(*graph);
  const std::vector<IsotropicWeights<Dim>> weights = WeightsOf(*graph);
  SolveRotations(pattern, held, weights, graph);
  SolveTranslations(pattern, held, weights, graph);
}

template <int Dim>
void InitializeChordalFromTrusted(PoseGraph<Dim>* graph) {
  PoseGraph<Dim> trusted = *graph;
  std::erase_if(trusted.edges, [](const GraphEdge<Dim>& edge) { return edge.robust; });
  const bool enough = ConnectedParts(trusted) == ConnectedParts(*graph);
  if (!enough) return InitializeChordal(graph);
  InitializeChordal(&trusted);
  graph->poses = trusted.poses;
}

template void InitializeChordalFromTrusted<2>(PoseGraph2*);
template void InitializeChordalFromTrusted<3>(PoseGraph3*);
template void InitializeChordal<2>(PoseGraph2*);
template void InitializeChordal<3>(PoseGraph3*);

}  // namespace planegraph
