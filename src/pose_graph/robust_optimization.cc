#include "planegraph/pose_graph/robust_optimization.h"

#include <algorithm>
#include <chrono>
#include <cmath>

#include "planegraph/base/chi_square.h"
#include "pose_graph/optimizer.h"

namespace planegraph {
namespace {

// The rounds before the last one only have to sort the edges.
constexpr double kRoundTolerance = 1e-4;

template <int Dim>
class GncRun {
 public:
  GncRun(PoseGraph<Dim>* graph, const GncOptions& options)
      : graph_(*graph),
        options_(options),
        scale_(options.scale > 0.0 ? options.scale
                                   : std::sqrt(ChiSquareQuantile(0.99, Dim == 3 ? 6 : 3))),
        schedule_(options.kernel, scale_),
        optimizer_((CheckIndices(*graph), graph), &solve_) {
    summary_.weights.assign(graph->edges.size(), 1.0);
  }

  GncSummary Run() {
    const auto start = std::chrono::steady_clock::now();
    Solve(kRoundTolerance);
    schedule_.Start(RobustChi2());
    while (!schedule_.Finished() && summary_.rounds < options_.max_rounds) {
      SetWeights([this](double chi2) { return schedule_.Weight(chi2); });
      Solve(kRoundTolerance);
      schedule_.Advance(RobustChi2());
    }
    SetWeights([this](double chi2) { return schedule_.FinalWeight(chi2); });
    Solve(PoseGraphOptions().tolerance);
    summary_.robust_cost = RobustCost();
    summary_.last.seconds =
        std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    return summary_;
  }

 private:
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

  void Solve(double tolerance) {
    solve_.weights = summary_.weights;
    solve_.tolerance = tolerance;
    const PoseGraphSummary before = summary_.last;
    summary_.last = optimizer_.Run();
    summary_.last.iterations += before.iterations;
    summary_.last.factorizations += before.factorizations;
    ++summary_.rounds;
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
  PoseGraphOptions solve_;
  Optimizer<Dim> optimizer_;
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
