// Poses that all registrations between scans agree with, before any plane is looked at.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <set>

#include "pipeline/graph_building.h"
#include "planegraph/base/chi_square.h"
#include "planegraph/pipeline/joint_solve.h"
#include "planegraph/pipeline/loop_consistency.h"

namespace planegraph {
namespace {

constexpr double kConfidence = 1.0 - 1e-6;  // as of cycles: beyond all chance

Graph PosesOnly(const std::vector<Rigid3>& poses, const std::vector<int>& component) {
  Graph graph;
  std::set<int> seen;
  for (std::size_t i = 0; i < poses.size(); ++i) {
    // Each component has a gauge of its own: its first scan.
    graph.poses.push_back({std::to_string(i), poses[i], seen.insert(component[i]).second});
  }
  return graph;
}

void AddRegistrations(const std::vector<PairRecord>& pairs, Graph* graph) {
  for (std::size_t k = 0; k < pairs.size(); ++k) {
    const PairRecord& pair = pairs[k];
    if (!pair.used) continue;
    PoseFactor factor =
        MakeRelativePose(static_cast<int>(pair.target), static_cast<int>(pair.source),
                         pair.registration.target_from_source(),
                         PositiveInverse(pair.registration.refinement.covariance), "registration");
    factor.robust = true;
    factor.user_tag = static_cast<int>(k);
    graph->pose_factors.push_back(factor);
  }
}

// Loops in groups, registrations of steps each by itself; what nothing else holds is trusted.
void GroupFactors(const std::vector<ScanRecord>& scans, const std::vector<PairRecord>& pairs,
                  const std::vector<OdometryStep>& odometry, const std::vector<int>& groups,
                  const Loops& loops, Graph* graph) {
  for (PoseFactor& factor : graph->pose_factors) {
    if (factor.user_tag < 0) continue;
    const auto pair = static_cast<std::size_t>(factor.user_tag);
    const auto loop = std::find(loops.pairs.begin(), loops.pairs.end(), pair);
    if (loop != loops.pairs.end()) factor.group = groups[loop - loops.pairs.begin()];
    factor.robust = !IsStep(scans, pairs[pair]) || FindStep(odometry, pairs[pair]) != nullptr;
  }
}

void TakeOut(const std::vector<ScanRecord>& scans, const ResidualReport& report, double limit,
             PairRecord* pair, std::vector<SwitchedOff>* off) {
  SwitchedOff entry{"laser-laser", scans[pair->target].id, scans[pair->source].id, "loss"};
  entry.weight = report.weight;
  entry.sigmas = std::sqrt(report.chi2);
  entry.threshold_sigmas = std::sqrt(limit);
  char text[160];
  std::snprintf(text, sizeof(text),
                "the other registrations and the odometry switched it off: it is %.0f standard "
                "deviations off, of at most %.1f",
                entry.sigmas, entry.threshold_sigmas);
  entry.reason = text;
  pair->registration.status = RegistrationStatus::kAmbiguous;
  pair->registration.reason = text;
  pair->used = false;
  off->push_back(std::move(entry));
}

SolveOptions QuickOptions() {
  SolveOptions options;
  options.pose_loss = {"cauchy", 2.4};
  options.max_iterations = 20;
  options.function_tolerance = 1e-4;  // a start for the association, no more
  return options;
}

// Judges the registrations by graduated non-convexity and takes those out that end without weight.
void Judge(const std::vector<ScanRecord>& scans, const std::vector<OdometryStep>& odometry,
           const LossSpec& loss, Graph graph, std::vector<PairRecord>* pairs,
           std::vector<SwitchedOff>* off) {
  constexpr int kReach = 3;
  const int poses = static_cast<int>(scans.size());
  const Loops loops = UsedLoops(scans, *pairs);
  const auto trusted = TrustedSteps(scans, *pairs, odometry);
  ConsistencyOptions agreement;
  agreement.variance_factor = MeasureVarianceFactor(poses, trusted, loops.closures);
  const auto groups = GroupClosures(poses, trusted, loops.closures, kReach, agreement);
  GroupFactors(scans, *pairs, odometry, groups, loops, &graph);
  const double limit = ChiSquareQuantile(kConfidence, 6) * agreement.variance_factor;
  SolveOptions options = QuickOptions();
  options.pose_loss = {loss.name, std::sqrt(limit)};
  const SolveSummary summary = Solve(&graph, options);
  for (const ResidualReport& report : summary.residuals) {
    const PoseFactor& factor = graph.pose_factors[report.tag.pose_factor];
    if (factor.user_tag < 0 || report.weight >= kOffWeight) continue;
    TakeOut(scans, report, limit, &(*pairs)[static_cast<std::size_t>(factor.user_tag)], off);
  }
}

}  // namespace

std::vector<Rigid3> SolveRelativePoses(const std::vector<ScanRecord>& scans,
                                       const std::vector<OdometryStep>& odometry,
                                       std::vector<Rigid3> start, const MapOptions& map_options,
                                       std::vector<PairRecord>* pairs,
                                       std::vector<SwitchedOff>* off) {
  const LossSpec own = MeasurementLoss(map_options, "relative_pose");
  const LossSpec& loss = IsGraduated(own) ? own : PlaneLoss(map_options);
  if (IsGraduated(loss)) {
    Graph graph = PosesOnly(start, Components(start.size(), *pairs));
    AddRegistrations(*pairs, &graph);
    AddOdometry(odometry, &graph, false);
    if (!graph.pose_factors.empty()) Judge(scans, odometry, loss, std::move(graph), pairs, off);
  }
  Graph graph = PosesOnly(start, Components(start.size(), *pairs));
  AddRegistrations(*pairs, &graph);
  AddOdometry(odometry, &graph);
  if (graph.pose_factors.empty()) return start;
  SolveOptions options = QuickOptions();
  options.collect_residuals = false;
  if (!IsGraduated(own)) options.pose_loss = own;
  Solve(&graph, options);
  return PosesOf(graph);
}

}  // namespace planegraph
