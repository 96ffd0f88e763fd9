#include "planegraph/pipeline/mapper.h"

#include <algorithm>
#include <atomic>
#include <chrono>

#include "planegraph/base/error.h"
#include "planegraph/base/parallel.h"
#include "planegraph/pipeline/joint_solve.h"
#include "planegraph/solve/metascan.h"

namespace planegraph {
namespace {

class Lap {
 public:
  explicit Lap(double* seconds) : seconds_(seconds) {}
  ~Lap() {
    *seconds_ += std::chrono::duration<double>(std::chrono::steady_clock::now() - start_).count();
  }

 private:
  double* seconds_;
  std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
};

std::vector<ScanRecord> PrepareScans(const Site& site, const MapOptions& options) {
  std::vector<std::pair<std::size_t, std::size_t>> jobs;
  for (std::size_t r = 0; r < site.robots.size(); ++r) {
    for (std::size_t i = 0; i < site.robots[r].scans.size(); ++i) jobs.push_back({r, i});
  }
  std::vector<ScanRecord> scans(jobs.size());
  std::atomic<std::size_t> done{0};
  ParallelFor(jobs.size(), options.threads, [&](std::size_t k) {
    scans[k] = PrepareScan(site, jobs[k].first, jobs[k].second, options.segmentation);
    options.progress("scans", static_cast<double>(++done) / static_cast<double>(jobs.size()));
  });
  return scans;
}

std::vector<ScanModel> MakeModels(const std::vector<ScanRecord>& scans, int threads) {
  std::vector<std::optional<ScanModel>> built(scans.size());
  ParallelFor(scans.size(), threads, [&](std::size_t i) { built[i].emplace(scans[i].planes); });
  std::vector<ScanModel> models;
  models.reserve(scans.size());
  for (auto& model : built) models.push_back(std::move(*model));
  return models;
}

// Registers scan to scan, along the way and around it, and finds poses that all of them agree with.
std::vector<Rigid3> RegisterScans(const MapOptions& options, MapResult* result) {
  const std::vector<ScanModel> models = MakeModels(result->scans, options.threads);
  options.progress("registration", 0.0);
  result->pairs =
      RegisterChain(models, result->scans, result->odometry, options.registration, options.threads);
  CalibrateOdometry(result->pairs, &result->odometry);
  options.progress("registration", 0.5);
  std::vector<Rigid3> poses =
      ChainPoses(result->site, result->scans, result->pairs, result->odometry);
  if (options.optimizer != "graph") return poses;
  auto more = RegisterNeighbours(models, poses, result->pairs, options.registration,
                                 options.neighbours_per_scan, options.threads);
  std::move(more.begin(), more.end(), std::back_inserter(result->pairs));
  options.progress("registration", 1.0);
  return SolveRelativePoses(result->pairs, result->odometry, poses, options.threads);
}

// Step q of the paper: the metascan, on the same segments.
JointSolution MatchSimultaneously(const std::vector<Rigid3>& start, MapResult* result) {
  std::vector<PlaneSet> sets;
  for (const auto& scan : result->scans) {
    sets.emplace_back();
    sets.back().kind = scan.planes.kind;
    sets.back().planes = scan.planes.planes;
  }
  const MetascanResult metascan = OptimizeMetascan(sets, start);
  if (!metascan.terminated) {
    result->warnings.push_back("the metascan's queue did not run empty; it was stopped");
  }
  JointSolution solution;
  solution.world_from_scan = metascan.poses;
  solution.summary.iterations = static_cast<int>(metascan.pops);
  solution.summary.converged = metascan.terminated;
  return solution;
}

void Check(const Site& site, const MapOptions& options, MapResult* result) {
  if (options.optimizer != "graph" && options.optimizer != "metascan" &&
      options.optimizer != "none") {
    throw UsageError("unknown optimizer '" + options.optimizer + "' (graph, metascan, none)");
  }
  BuiltinFactors().Get(options.plane_factor, FactorKind::kPlane);  // throws for an unknown one
  if (!site.maps.empty()) {
    result->warnings.push_back("drone maps are not used by this version: laser scans only");
  }
}

}  // namespace

MapResult MapScans(const Site& site, const MapOptions& options) {
  MapResult result;
  result.site = site;
  Check(site, options, &result);
  {
    Lap lap(&result.seconds.front_end);
    result.scans = PrepareScans(site, options);
  }
  result.odometry = OdometrySteps(site, result.scans);
  std::vector<Rigid3> start;
  {
    Lap lap(&result.seconds.pairing);
    start = RegisterScans(options, &result);
  }
  result.component = Components(result.scans.size(), result.pairs);
  result.components = *std::max_element(result.component.begin(), result.component.end()) + 1;
  result.solution.world_from_scan = start;
  if (options.optimizer == "graph") {
    Lap lap(&result.seconds.solve);
    result.solution = SolveJointly(result.scans, result.pairs, result.odometry, start, options);
  }
  if (options.optimizer == "metascan") {
    Lap lap(&result.seconds.solve);
    result.solution = MatchSimultaneously(start, &result);
  }
  if (options.optimizer == "graph") {
    Lap lap(&result.seconds.covariance);
    ComputeUncertainty(result.pairs, options, &result);
  }
  return result;
}

}  // namespace planegraph
