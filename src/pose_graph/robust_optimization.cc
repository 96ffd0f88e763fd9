#include "planegraph/pose_graph/robust_optimization.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <optional>
#include <utility>

#include "planegraph/base/chi_square.h"
#include "planegraph/base/median.h"
#include "pose_graph/optimizer.h"

namespace planegraph {
namespace {

// The first truncated surrogates weigh loop closures next to nothing, so that the poses stay near
// the others' minimum, and one step follows each change. Geman and McClure's first ones are almost
// least squares over all edges: a far way, of which the rounds before the last only have to see
// the end roughly.
constexpr int kTruncatedSteps = 1;
constexpr double kRoundTolerance = 1e-4;

// Edges that were switched off are taken out of the equations, whose order of elimination is then
// sought anew, as soon as they are this share of those that are left: false closures join distant
// poses, and the fill that they cause is most of the work.
constexpr double kSwitchedOff = 0.02;

// The truncated cost falls with every change of the weights, so few changes are needed.
constexpr int kMaxFinalSolves = 20;

// A bound by the noise that the edges show is taken where it is so much below the one by the noise
// that they claim; it is beyond all chance, as the noise need not be the same everywhere.
constexpr double kNoticeable = 0.75, kConfidence = 1.0 - 1e-6;
constexpr double kLeastRedundancy = 0.2;  // of the edges that are kept, for the noise to be seen

template <int Dim>
class GncRun {
 public:
  GncRun(PoseGraph<Dim>* graph, const GncOptions& options)
      : graph_(*graph),
        options_(options),
        scale_(options.scale > 0.0 ? options.scale
                                   : std::sqrt(ChiSquareQuantile(0.99, Dim == 3 ? 6 : 3))),
        schedule_(options.kernel, scale_) {
    CheckIndices(*graph);
    summary_.weights.assign(graph->edges.size(), 1.0);
  }

  GncSummary Run() {
    const auto start = std::chrono::steady_clock::now();
    const std::vector<GraphPose<Dim>> first = graph_.poses;
    Graduate();
    const double measured = MeasuredScale();
    if (options_.scale <= 0.0 && measured < kNoticeable * scale_) {
      graph_.poses = first;
      scale_ = measured;
      schedule_ = GncSchedule(options_.kernel, scale_);
      summary_.weights.assign(graph_.edges.size(), 1.0);
      Graduate();
    }
    summary_.robust_cost = RobustCost();
    summary_.scale = scale_;
    summary_.last.seconds =
        std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    return summary_;
  }

 private:
  void Graduate() {
    const bool truncated = options_.kernel == GncKernel::kTruncated;
    const int last_round = summary_.rounds + options_.max_rounds;
    solve_ = PoseGraphOptions();
    if (truncated) solve_.max_iterations = kTruncatedSteps;
    solve_.tolerance = kRoundTolerance;
    if (!truncated) Solve();
    schedule_.Start(RobustChi2());
    while (!schedule_.Finished() && summary_.rounds < last_round) {
      SetWeights([this](double chi2) { return schedule_.Weight(chi2); });
      Solve();
      schedule_.Advance(RobustChi2());
    }
    SolveFinally();
  }

  // The bound by the noise of the edges that were kept: the median of their chi2, which no few
  // false ones move, less what the unknowns take of it.
  double MeasuredScale() const {
    constexpr int kDegrees = kPoseDimension<Dim>;
    std::vector<double> chi2;
    for (std::size_t k = 0; k < graph_.edges.size(); ++k) {
      if (summary_.weights[k] >= 0.5) chi2.push_back(EdgeChi2(graph_, graph_.edges[k]));
    }
    const double redundancy =
        1.0 - static_cast<double>(graph_.poses.size()) / std::max<double>(1.0, chi2.size());
    if (redundancy < kLeastRedundancy) return scale_;
    const double variance =
        Median(std::move(chi2)) / (redundancy * ChiSquareQuantile(0.5, kDegrees));
    return std::sqrt(variance * ChiSquareQuantile(kConfidence, kDegrees));
  }

  std::vector<double> RobustChi2() const {
    std::vector<double> chi2;
    for (const GraphEdge<Dim>& edge : graph_.edges) {
      if (edge.robust) chi2.push_back(EdgeChi2(graph_, edge));
    }
    return chi2;
  }

  template <typename Weight>
  void SetWeights(const Weight& weight) {
    for (std::size_t k = 0; k < graph_.edges.size(); ++k) {
      const GraphEdge<Dim>& edge = graph_.edges[k];
      if (edge.robust) summary_.weights[k] = weight(EdgeChi2(graph_, edge));
    }
  }

  // With the weights of the robust cost itself, until these stay (0 and 1 do, others hardly).
  void SolveFinally() {
    solve_.max_iterations = PoseGraphOptions().max_iterations;
    solve_.tolerance = PoseGraphOptions().tolerance;
    damping_ = 0.0;
    const int most = options_.kernel == GncKernel::kTruncated ? kMaxFinalSolves : 1;
    std::vector<double> before;
    for (int k = 0; k < most && summary_.weights != before; ++k) {
      SetWeights([this](double chi2) { return schedule_.FinalWeight(chi2); });
      Solve();
      before = summary_.weights;
      SetWeights([this](double chi2) { return schedule_.FinalWeight(chi2); });
    }
  }

  void Solve() {
    TakeActiveEdges();
    const PoseGraphSummary before = summary_.last;
    summary_.last = optimizer_->Run(damping_);
    damping_ = optimizer_->damping();
    graph_.poses = active_.poses;
    summary_.last.iterations += before.iterations;
    summary_.last.factorizations += before.factorizations;
    ++summary_.rounds;
  }

  // The edges with a weight, or those of the last round where few have lost theirs.
  void TakeActiveEdges() {
    std::vector<std::size_t> weighted;
    for (std::size_t k = 0; k < graph_.edges.size(); ++k) {
      if (summary_.weights[k] > 0.0) weighted.push_back(k);
    }
    const double least = (1.0 - kSwitchedOff) * static_cast<double>(active_edges_.size());
    const bool contained =
        std::includes(active_edges_.begin(), active_edges_.end(), weighted.begin(), weighted.end());
    if (!contained || static_cast<double>(weighted.size()) < least) Activate(std::move(weighted));
    solve_.weights.clear();
    for (const std::size_t k : active_edges_) solve_.weights.push_back(summary_.weights[k]);
  }

  void Activate(std::vector<std::size_t> edges) {
    active_edges_ = std::move(edges);
    active_ = {graph_.poses, graph_.fixed, {}, graph_.rotation_residual};
    for (const std::size_t k : active_edges_) active_.edges.push_back(graph_.edges[k]);
    optimizer_.emplace(&active_, &solve_);
  }

  double RobustCost() const {
    const double limit = scale_ * scale_;
    double sum = 0.0;
    for (const GraphEdge<Dim>& edge : graph_.edges) {
      const double chi2 = EdgeChi2(graph_, edge);
      if (!edge.robust) {
        sum += chi2;
      } else if (options_.kernel == GncKernel::kTruncated) {
        sum += std::min(chi2, limit);
      } else {
        sum += limit * chi2 / (limit + chi2);
      }
    }
    return 0.5 * sum;
  }

  PoseGraph<Dim>& graph_;
  const GncOptions& options_;
  double scale_;
  GncSchedule schedule_;
  PoseGraph<Dim> active_;
  std::vector<std::size_t> active_edges_;  // their indices in graph_, increasing
  PoseGraphOptions solve_;
  std::optional<Optimizer<Dim>> optimizer_;
  double damping_ = 0.0;
  GncSummary summary_;
};

}  // namespace

template <int Dim>
GncSummary OptimizeByGnc(PoseGraph<Dim>* graph, const GncOptions& options) {
  return GncRun<Dim>(graph, options).Run();
}

template GncSummary OptimizeByGnc<2>(PoseGraph2*, const GncOptions&);
template GncSummary OptimizeByGnc<3>(PoseGraph3*, const GncOptions&);

}  // namespace planegraph
