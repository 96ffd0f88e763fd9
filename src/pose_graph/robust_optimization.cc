#include "planegraph/pose_graph/robust_optimization.h"

#include <algorithm>
#include <cmath>

namespace planegraph {
namespace {

// 99 % quantiles of chi-square with 3 and with 6 degrees of freedom (Abramowitz and Stegun, table
// 26.8).
constexpr double kChi2Of3 = 11.345, kChi2Of6 = 16.812;

template <int Dim>
class GncRun {
 public:
  GncRun(PoseGraph<Dim>* graph, const GncOptions& options)
      : graph_(*graph),
        options_(options),
        scale_(options.scale > 0.0 ? options.scale : std::sqrt(Dim == 3 ? kChi2Of6 : kChi2Of3)),
        schedule_(options.kernel, scale_) {
    summary_.weights.assign(graph->edges.size(), 1.0);
  }

  GncSummary Run() {
    Solve();
    schedule_.Start(RobustChi2());
    while (!schedule_.Finished() && summary_.rounds < options_.max_rounds) {
      SetWeights([this](double chi2) { return schedule_.Weight(chi2); });
      Solve();
      schedule_.Advance(RobustChi2());
    }
    SetWeights([this](double chi2) { return schedule_.FinalWeight(chi2); });
    Solve();
    summary_.robust_cost = RobustCost();
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

  void Solve() {
    PoseGraphOptions options;
    options.weights = summary_.weights;
    const PoseGraphSummary before = summary_.last;
    summary_.last = OptimizePoseGraph(&graph_, options);
    summary_.last.iterations += before.iterations;
    summary_.last.factorizations += before.factorizations;
    summary_.last.seconds += before.seconds;
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
