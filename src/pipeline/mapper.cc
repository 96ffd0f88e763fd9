#include "planegraph/pipeline/mapper.h"

#include <algorithm>
#include <atomic>

#include "pipeline/input_warnings.h"
#include "pipeline/lap.h"
#include "pipeline/odometry_conventions.h"
#include "planegraph/base/error.h"
#include "planegraph/base/parallel.h"
#include "planegraph/graph/factor_losses.h"
#include "planegraph/pipeline/joining.h"
#include "planegraph/pipeline/joint_solve.h"
#include "planegraph/pipeline/loop_consistency.h"
#include "planegraph/solve/metascan.h"

namespace planegraph {
namespace {

std::vector<ScanRecord> PrepareScans(const Site& site, const MapOptions& options) {
  std::vector<std::pair<std::size_t, std::size_t>> jobs;
  for (std::size_t r = 0; r < site.robots.size(); ++r) {
    for (const std::size_t i : OrderAlongWay(site.robots[r])) jobs.emplace_back(r, i);
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

// Of a site file it is the file that lacks something, not the command line.
MapRecord PrepareMapOfSite(const Site& site, std::size_t m, const MapOptions& options,
                           std::vector<std::string>* warnings) {
  try {
    return PrepareMap(site, m, options.threads, warnings, options.map_memory);
  } catch (const UsageError& error) {
    throw InputError::InFile(
        site.maps[m].gps,
        std::string(error.what()) + ": state `image_times` of the map " + site.maps[m].name);
  }
}

std::vector<MapRecord> PrepareMaps(const Site& site, const MapOptions& options, MapResult* result) {
  std::vector<MapRecord> maps;
  for (std::size_t m = 0; m < site.maps.size(); ++m) {
    options.progress("maps", static_cast<double>(m) / static_cast<double>(site.maps.size()));
    maps.push_back(PrepareMapOfSite(site, m, options, &result->warnings));
  }
  if (!maps.empty()) options.progress("maps", 1.0);
  return maps;
}

constexpr int kStartFrame = -1, kPlacedFrame = -2;  // others: the robot's index

// Scans of one robot are in one frame by its odometry or by registrations, robots with a start in
// the world's: only such scans can be neighbours by their poses.
std::vector<int> FramesOf(const Site& site, const std::vector<ScanRecord>& scans) {
  std::vector<int> frames;
  frames.reserve(scans.size());
  for (const ScanRecord& scan : scans) {
    frames.push_back(site.robots[scan.robot].start ? kStartFrame : static_cast<int>(scan.robot));
  }
  return frames;
}

void AddNeighbours(const std::vector<ScanModel>& models, const std::vector<Rigid3>& poses,
                   const std::vector<int>& frames, const MapOptions& options, MapResult* result) {
  auto more = RegisterNeighbours(models, poses, frames, result->pairs, options.registration,
                                 options.neighbours_per_scan, options.threads);
  std::move(more.begin(), more.end(), std::back_inserter(result->pairs));
}

// Robots that have nothing but their scans in common are joined by these.
void JoinRobots(const std::vector<ScanModel>& models, const MapOptions& options,
                std::vector<int>* frames, std::vector<Rigid3>* poses, MapResult* result) {
  auto joined = JoinFrames(models, options.registration, options.threads, poses, frames);
  if (joined.empty()) return;
  std::move(joined.begin(), joined.end(), std::back_inserter(result->pairs));
  if (options.optimizer == "graph") AddNeighbours(models, *poses, *frames, options, result);
}

// Registers scan to scan, along the way and around it (steps l to p of the paper), and finds poses
// that all of them agree with.
std::vector<Rigid3> RegisterScans(const std::vector<ScanModel>& models, const MapOptions& options,
                                  MapResult* result) {
  options.progress("registration", 0.0);
  result->pairs =
      RegisterChain(models, result->scans, result->odometry, options.registration, options.threads);
  for (std::string& warning :
       OdometryConventionWarnings(result->site, result->scans, result->pairs)) {
    result->warnings.push_back(std::move(warning));
  }
  const OdometryScatter scatter = CalibrateOdometry(result->pairs, &result->odometry);
  result->odometry_scales =
      ScaleOdometry(result->pairs, result->site.robots.size(), &result->odometry);
  ReviseChain(models, result->odometry, scatter, options.registration, options.threads,
              &result->pairs);
  options.progress("registration", 0.5);
  std::vector<Rigid3> poses =
      ChainPoses(result->site, result->scans, result->pairs, result->odometry);
  std::vector<int> frames = FramesOf(result->site, result->scans);
  if (options.optimizer == "graph") AddNeighbours(models, poses, frames, options, result);
  if (result->maps.empty()) JoinRobots(models, options, &frames, &poses, result);
  if (options.optimizer == "graph") {
    RefuseInconsistentLoops(result->scans, result->odometry, &result->pairs, &result->refused);
    poses = SolveRelativePoses(result->scans, result->odometry, poses, options, &result->pairs,
                               &result->refused);
  }
  options.progress("registration", 1.0);
  return poses;
}

// Finds the robots in the drone maps and registers every scan to what the maps have of its
// surroundings (steps f to h of the paper). Robots that share nothing else meet in the map.
void RegisterInMaps(const std::vector<ScanModel>& models, const MapOptions& options,
                    Placement* placement, MapResult* result) {
  std::vector<MapModel> map_models;
  for (const MapRecord& map : result->maps) map_models.emplace_back(map.planes);
  const std::vector<int> component = Components(result->scans.size(), result->pairs);
  const auto tell = [&](double share) { options.progress("placing", 0.9 * share); };
  PlaceInMaps({result->site, models, result->scans, component, result->odometry, result->maps,
               map_models, result->robot_positions, options.threads, tell},
              placement, &result->map_pairs);
  std::vector<int> frames = FramesOf(result->site, result->scans);
  for (std::size_t i = 0; i < frames.size(); ++i) {
    if (placement->placed[i]) frames[i] = kPlacedFrame;
  }
  if (options.optimizer == "graph") {
    AddNeighbours(models, placement->world_from_scan, frames, options, result);
  }
  JoinRobots(models, options, &frames, &placement->world_from_scan, result);
  if (options.optimizer == "graph") {
    RefuseInconsistentLoops(result->scans, result->odometry, &result->pairs, &result->refused);
  }
  for (std::size_t i = 0; i < frames.size(); ++i) {
    if (frames[i] == kPlacedFrame) placement->placed[i] = true;
  }
  auto records = RegisterToMaps(models, map_models, *placement, options.threads);
  std::move(records.begin(), records.end(), std::back_inserter(result->map_pairs));
}

// Step q of the paper: the metascan, on the same segments. Scans that a drone map covers have their
// registration to it; the others are matched to each other and to these.
JointSolution MatchSimultaneously(const Placement& placement, MapResult* result) {
  std::vector<Rigid3> start = placement.world_from_scan;
  MetascanOptions options;
  options.fixed.assign(start.size(), false);
  for (const MapPairRecord& pair : result->map_pairs) {
    if (!pair.used || options.fixed[pair.scan]) continue;
    const Sim3 found = placement.world_from_metric[pair.map] * pair.refinement.map_from_group;
    start[pair.scan] = {found.rotation, found.translation};
    options.fixed[pair.scan] = true;
  }
  std::vector<PlaneSet> sets;
  for (const auto& scan : result->scans) {
    sets.emplace_back();
    sets.back().kind = scan.planes.kind;
    sets.back().planes = scan.planes.planes;
  }
  const MetascanResult metascan = OptimizeMetascan(sets, start, options);
  if (!metascan.terminated) {
    result->warnings.emplace_back("the metascan's queue did not run empty; it was stopped");
  }
  JointSolution solution;
  solution.world_from_scan = metascan.poses;
  solution.summary.iterations = static_cast<int>(metascan.pops);
  solution.summary.converged = metascan.terminated;
  return solution;
}

void Check(const MapOptions& options) {
  if (options.optimizer != "graph" && options.optimizer != "metascan" &&
      options.optimizer != "none") {
    throw UsageError("unknown optimizer '" + options.optimizer + "' (graph, metascan, none)");
  }
  BuiltinFactors().Get(options.plane_factor, FactorKind::kPlane);  // throws for an unknown one
  CheckFactorNames(options.factor_losses, BuiltinFactors());
}

Placement StartPlacement(std::vector<Rigid3> poses, const std::vector<MapRecord>& maps) {
  Placement placement;
  placement.placed.assign(poses.size(), false);
  placement.world_from_scan = std::move(poses);
  placement.errors.resize(maps.size());
  for (const MapRecord& map : maps) placement.world_from_metric.push_back(map.world_from_metric);
  return placement;
}

void Optimize(const Placement& placement, const MapOptions& options, MapResult* result) {
  Lap lap(&result->seconds.solve);
  options.progress("solve", 0.0);
  result->solution.world_from_scan = placement.world_from_scan;
  result->solution.world_from_metric = placement.world_from_metric;
  if (options.optimizer == "graph") {
    result->solution =
        SolveJointly({&result->site, &result->scans, &result->pairs, &result->odometry,
                      &result->maps, &result->map_pairs, &placement, &result->robot_positions},
                     options);
  }
  if (options.optimizer == "metascan") {
    result->solution = MatchSimultaneously(placement, result);
    result->solution.world_from_metric = placement.world_from_metric;
  }
}

// Gives the user the warnings that have come since the last time.
class WarningTeller {
 public:
  WarningTeller(const MapOptions& options, const MapResult& result)
      : options_(options), result_(result) {}
  void Tell() {
    for (; told_ < result_.warnings.size(); ++told_) options_.warn(result_.warnings[told_]);
  }

 private:
  const MapOptions& options_;
  const MapResult& result_;
  std::size_t told_ = 0;
};

}  // namespace

const LossSpec& PlaneLoss(const MapOptions& options) {
  const auto own = options.factor_losses.find(options.plane_factor);
  return own == options.factor_losses.end() ? options.loss : own->second;
}

LossSpec MeasurementLoss(const MapOptions& options, const std::string& factor) {
  const auto own = options.factor_losses.find(factor);
  return own == options.factor_losses.end() ? LossSpec{"cauchy", 2.4} : own->second;
}

std::string LossText(const MapOptions& options) {
  return FactorLosses{options.loss, options.factor_losses}.ToString();
}

MapResult MapScans(const Site& site, const MapOptions& options) {
  Check(options);
  MapResult result;
  WarningTeller teller(options, result);
  result.site = site;
  result.warnings = OdometryWarnings(site);
  for (const DroneMapSite& map : site.maps) {
    if (!map.tiles || options.optimizer == "graph") continue;
    result.warnings.push_back(map.name + ": it stays one piece: tiles need the optimizer graph");
  }
  teller.Tell();
  {
    Lap lap(&result.seconds.front_end);
    result.scans = PrepareScans(site, options);
  }
  for (std::string& warning : UnitsWarnings(site, result.scans)) {
    result.warnings.push_back(std::move(warning));
  }
  teller.Tell();
  {
    Lap lap(&result.seconds.maps);
    result.maps = PrepareMaps(site, options, &result);
  }
  result.odometry = OdometrySteps(site, result.scans);
  result.robot_positions = ReadRobotPositions(site, result.scans, result.maps, &result.warnings);
  teller.Tell();
  Placement placement;
  const std::vector<ScanModel> models = MakeModels(result.scans, options.threads);
  {
    Lap lap(&result.seconds.pairing);
    placement = StartPlacement(RegisterScans(models, options, &result), result.maps);
  }
  teller.Tell();
  if (!result.maps.empty()) {
    Lap lap(&result.seconds.placing);
    options.progress("placing", 0.0);
    RegisterInMaps(models, options, &placement, &result);
    options.progress("placing", 1.0);
  }
  result.component = Components(result.scans.size(), result.pairs, result.map_pairs);
  result.components = *std::max_element(result.component.begin(), result.component.end()) + 1;
  Optimize(placement, options, &result);
  if (options.optimizer == "graph") {
    Lap lap(&result.seconds.covariance);
    options.progress("covariance", 0.0);
    ComputeUncertainty(result.pairs, options, &result);
    options.progress("covariance", 1.0);
  }
  teller.Tell();
  return result;
}

std::vector<std::size_t> ScansInFileOrder(const MapResult& result, std::size_t robot) {
  std::vector<std::size_t> order;
  for (std::size_t i = 0; i < result.scans.size(); ++i) {
    if (result.scans[i].robot == robot) order.push_back(i);
  }
  std::sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
    return result.scans[a].index < result.scans[b].index;
  });
  return order;
}

}  // namespace planegraph
