#include "planegraph/pose_graph/certificate.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <limits>
#include <stdexcept>

#include "pose_graph/dual_matrix.h"
#include "pose_graph/lifted_graph.h"
#include "pose_graph/optimizer.h"

namespace planegraph {
namespace {

// Gaps that are tried: from what rounding allows, by tens.
constexpr double kLeastGap = 1e-9, kMostGap = 1e3;

// Dimensions that the staircase adds at most. A stationary point whose columns do not span all of
// them is a minimum of the relaxation (Boumal et al. 2016); graphs of real measurements need one or
// two, and each one costs more than the one before.
constexpr int kMostRank = 4;
constexpr int kMostEscapes = 5;

double Now() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

template <int Dim>
void Check(const PoseGraph<Dim>& graph) {
  CheckIndices(graph);
  if (graph.rotation_residual != RotationResidual::kHalfSine ||
      std::count(graph.fixed.begin(), graph.fixed.end(), true) > 1) {
    throw std::invalid_argument("the certificate needs a free gauge and half-sine residuals");
  }
}

// What is wanted of a point that fails: nothing, or how far it may be from the optimum and where
// the way down is, for further factorizations.
enum class OnFailure { kNothing, kDirection };

// Whether no lower F exists in the relaxation, and how far the lifted point may be above it.
template <int Dim>
class Proof {
 public:
  Proof(const PoseGraph<Dim>& graph, const LiftedGraph<Dim>& lifted)
      : objective_(lifted.Objective()),
        rows_(Dim * static_cast<double>(graph.poses.size())),
        nothing_(kNothing * static_cast<double>(graph.edges.size())),
        multipliers_(lifted.Multipliers()),
        dual_(graph, lifted.blocks(), lifted.held(), lifted.pattern()) {}

  Certificate Run(OnFailure on_failure) {
    Certificate certificate;
    certificate.objective = objective_;
    double gap = ProvenGap();
    certificate.certified = gap <= kCertifiedGap;
    // Edges without contradiction: the optimizer rests there as well, and zero is the least F.
    if (objective_ <= nothing_) certificate.certified = true;
    if (!certificate.certified && on_failure == OnFailure::kDirection) {
      gap = LargeGap();
      if (gap <= kMostGap) certificate.direction = dual_.SteepestDescent();
    }
    certificate.suboptimality_bound = objective_ * std::min(gap, 1.0);  // F is nowhere negative
    return certificate;
  }

 private:
  static constexpr double kNone = std::numeric_limits<double>::infinity();

  bool Holds(double gap) { return dual_.IsPositive(multipliers_, gap * objective_ / rows_); }

  // Up to kCertifiedGap, infinity where none holds. Points hold at once or, mostly, not at all:
  // between the two ends is looked last.
  double ProvenGap() {
    if (Holds(kLeastGap)) return kLeastGap;
    if (!Holds(kCertifiedGap)) return kNone;
    for (double gap = 10.0 * kLeastGap; gap < 0.5 * kCertifiedGap; gap *= 10.0) {
      if (Holds(gap)) return gap;
    }
    return kCertifiedGap;
  }

  // Beyond kCertifiedGap, infinity where none holds. Its factorization is the last one.
  double LargeGap() {
    for (double gap = 10.0 * kCertifiedGap; gap <= kMostGap; gap *= 10.0) {
      if (Holds(gap)) return gap;
    }
    return kNone;
  }

  double objective_, rows_, nothing_;
  std::vector<typename LiftedGraph<Dim>::Small> multipliers_;
  DualMatrix<Dim> dual_;
};

template <int Dim>
Certificate CertifyLifted(const PoseGraph<Dim>& graph, const LiftedGraph<Dim>& lifted,
                          OnFailure on_failure) {
  return Proof<Dim>(graph, lifted).Run(on_failure);
}

// Up the staircase from a local minimum, and back to poses. False where no way leads down.
template <int Dim>
bool LeaveLocalMinimum(const PoseGraph<Dim>& graph, const Eigen::MatrixXd& direction,
                       std::vector<GraphPose<Dim>>* poses) {
  LiftedGraph<Dim> lifted(graph);
  Eigen::MatrixXd down = direction;
  while (lifted.rank() < Dim + kMostRank && down.size() > 0) {
    if (!lifted.Escape(down)) return false;
    lifted.Minimize();
    down = CertifyLifted(graph, lifted, OnFailure::kDirection).direction;
  }
  *poses = lifted.Rounded();
  return true;
}

template <int Dim>
class CertifiedRun {
 public:
  explicit CertifiedRun(PoseGraph<Dim>* graph) : graph_(*graph) {}

  CertifiedSummary Run() {
    Descend({});
    return Prove();
  }

  // From a minimum on.
  CertifiedSummary Prove() {
    summary_.certificate = TimedCertificate(OnFailure::kNothing);
    if (!summary_.certificate.certified) Polish();
    while (!summary_.certificate.certified && summary_.escapes < kMostEscapes) {
      if (!Escape()) break;
    }
    return summary_;
  }

 private:
  void Descend(const PoseGraphOptions& options) {
    const PoseGraphSummary before = summary_.optimization;
    summary_.optimization = OptimizePoseGraph(&graph_, options);
    if (before.iterations > 0) summary_.optimization.initial_cost = before.initial_cost;
    summary_.optimization.iterations += before.iterations;
    summary_.optimization.factorizations += before.factorizations;
    summary_.optimization.seconds += before.seconds;
  }

  Certificate TimedCertificate(OnFailure on_failure) {
    const double start = Now();
    Certificate certificate = CertifyLifted(graph_, LiftedGraph<Dim>(graph_), on_failure);
    summary_.seconds_certificate += Now() - start;
    return certificate;
  }

  // The bound is no better than the minimum is exact.
  void Polish() {
    PoseGraphOptions options;
    options.tolerance = 1e-12;
    options.near_minimum = true;
    Descend(options);
    summary_.certificate = TimedCertificate(OnFailure::kDirection);
  }

  // Whether it led to poses with a lower cost.
  bool Escape() {
    const PoseGraph<Dim> before = graph_;
    if (!LeaveLocalMinimum(before, summary_.certificate.direction, &graph_.poses)) return false;
    ++summary_.escapes;
    Descend({});
    const Certificate certificate = TimedCertificate(OnFailure::kNothing);
    if (certificate.objective >= summary_.certificate.objective) {
      graph_.poses = before.poses;
      summary_.optimization.final_cost = 0.5 * summary_.certificate.objective;
      return false;
    }
    summary_.certificate = certificate;
    if (!certificate.certified) Polish();
    return true;
  }

  PoseGraph<Dim>& graph_;
  CertifiedSummary summary_;
};

}  // namespace

template <int Dim>
Certificate Certify(const PoseGraph<Dim>& graph) {
  Check(graph);
  return CertifyLifted(graph, LiftedGraph<Dim>(graph), OnFailure::kDirection);
}

template <int Dim>
CertifiedSummary OptimizeCertified(PoseGraph<Dim>* graph) {
  Check(*graph);
  return CertifiedRun<Dim>(graph).Run();
}

template <int Dim>
CertifiedSummary CertifyMinimum(PoseGraph<Dim>* graph) {
  Check(*graph);
  return CertifiedRun<Dim>(graph).Prove();
}

template Certificate Certify<2>(const PoseGraph2&);
template Certificate Certify<3>(const PoseGraph3&);
template CertifiedSummary OptimizeCertified<2>(PoseGraph2*);
template CertifiedSummary OptimizeCertified<3>(PoseGraph3*);
template CertifiedSummary CertifyMinimum<2>(PoseGraph2*);
template CertifiedSummary CertifyMinimum<3>(PoseGraph3*);

}  // namespace planegraph
