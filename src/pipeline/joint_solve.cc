#include "planegraph/pipeline/joint_solve.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <map>
#include <memory>
#include <set>

#include "pipeline/graph_building.h"
#include "pipeline/group_judgement.h"
#include "pipeline/tiled_graph.h"
#include "planegraph/base/disjoint_sets.h"
#include "planegraph/base/median.h"
#include "planegraph/solve/covariance.h"

namespace planegraph {
namespace {

constexpr double kFirstGate = 0.25, kLastGate = 0.05;  // metres
constexpr double kFloorGate = 4.0;  // the last gate is at least this many noise floors
const double kAcross = std::sin(3.0 * 3.14159265358979 / 180.0);

// What rest means: metres that a solve may still move a scan, seen from the first one of those
// that registrations join it to, and these as a whole, where a map alone joins them to others: a
// map's own errors are larger. Seen from within, since where GPS of metres alone holds a site, its
// place in the world creeps on when all within it has come to rest.
struct Rest {
  double last_gate, stable, stable_in_map;
  std::vector<int> joined;     // component of each scan by registrations between scans
  std::vector<int> component;  // maps included
};

double LargestMove(const std::vector<Rigid3>& a, const std::vector<Rigid3>& b,
                   const std::vector<int>& component) {
  std::map<int, std::size_t> first;
  double move = 0.0;
  for (std::size_t i = 0; i < a.size(); ++i) {
    const std::size_t k = first.try_emplace(component[i], i).first->second;
    const Eigen::Vector3d now = (a[k].Inverse() * a[i]).translation;
    move = std::max(move, (now - (b[k].Inverse() * b[i]).translation).norm());
  }
  return move;
}

bool Rests(const std::vector<Rigid3>& a, const std::vector<Rigid3>& b, const Rest& rest) {
  return LargestMove(a, b, rest.joined) < rest.stable &&
         LargestMove(a, b, rest.component) < rest.stable_in_map;
}

// Whether GPS alone keeps the graph, or a part of it, in its place.
bool HeldByPriors(const Graph& graph) {
  return std::any_of(graph.map_factors.begin(), graph.map_factors.end(),
                     [](const MapFactor& factor) { return factor.maps.size() == 1; });
}

void TakeOver(const JointProblem& problem, Graph graph, JointSolution* solution) {
  solution->world_from_scan = PosesOf(graph);
  TakeMapsOver(problem, graph, solution);
  solution->graph = std::move(graph);
}

SolveOptions RoundOptions(const MapOptions& options, bool last, bool held_by_priors = false) {
  SolveOptions solve;
  solve.plane_factor = options.plane_factor;
  solve.plane_factor_options = options.plane_factor_options;
  solve.plane_loss = options.loss;
  solve.pose_loss = MeasurementLoss(options, "");
  solve.factor_losses = options.factor_losses;
  // The rounds before the last only have to bring surfaces together that the next association then
  // pairs anew. Robust losses converge linearly; a millionth of the cost is microns of a pose.
  solve.max_iterations = last ? 25 : 5;
  solve.function_tolerance = last ? 1e-6 : 1e-4;
  solve.collect_residuals = last || IsGraduated(PlaneLoss(options));
  solve.initial_radius = held_by_priors ? 1e10 : 1e4;
  return solve;
}

// Association and solve in turns until no pose moves at the last gate, or the rounds are used up.
void Rounds(const JointProblem& problem, const MapOptions& options, const Rest& rest,
            MapWeights* weights, AssociationOptions* association, JointSolution* solution,
            GroupJudgement* judgement) {
  bool last = false;
  for (; solution->rounds < options.most_rounds && !last; ++solution->rounds) {
    Graph graph = BuildGraph(problem, *solution, *association, *weights);
    if (judgement != nullptr) judgement->Apply(&graph);
    CutMaps(*solution, &graph);
    solution->summary = Solve(&graph, RoundOptions(options, false, HeldByPriors(graph)));
    solution->costs.push_back(solution->summary.costs);
    if (judgement != nullptr) judgement->Record(graph, solution->summary, PlaneLoss(options));
    last = association->gate <= rest.last_gate &&
           Rests(PosesOf(graph), solution->world_from_scan, rest);
    TakeOver(problem, std::move(graph), solution);
    WeighBentMaps(problem, *solution, weights, association);
    association->gate = std::max(rest.last_gate, 0.4 * association->gate);
    options.progress("solve", static_cast<double>(solution->rounds + 1) / options.most_rounds);
  }
}

// The last solve of the last association, to the end; whether it left the poses at rest.
bool FinishSolve(const JointProblem& problem, const MapOptions& options, const Rest& rest,
                 JointSolution* solution) {
  const double initial_cost = solution->summary.initial_cost;
  solution->summary =
      Solve(&solution->graph, RoundOptions(options, true, HeldByPriors(solution->graph)));
  solution->costs.push_back(solution->summary.costs);
  solution->summary.initial_cost = initial_cost;
  const std::vector<Rigid3> poses = PosesOf(solution->graph);
  solution->last_move = LargestMove(poses, solution->world_from_scan, rest.component);
  const bool rests = Rests(poses, solution->world_from_scan, rest);
  // Robust losses creep on for long at surfaces that fit nowhere; what counts is that the poses
  // rest.
  solution->summary.converged |= rests;
  TakeOver(problem, std::move(solution->graph), solution);
  return rests;
}

// What is off says nothing of the covariances either.
void ListSwitchedOff(const JointProblem& problem, const MapOptions& options,
                     GroupJudgement* judgement, JointSolution* solution) {
  solution->switched_off = MeasurementsOff(problem, solution->graph, solution->summary);
  if (judgement == nullptr) return;
  judgement->Record(solution->graph, solution->summary, PlaneLoss(options));
  for (auto& off : judgement->Off()) solution->switched_off.push_back(std::move(off));
  RemoveSwitchedOff(solution->summary, &solution->graph);
}

// Information on a position in the world, one axis, 1/m^2.
double CameraInformation(const std::vector<MapRecord>& maps) {
  double information = 0.0;
  for (const MapRecord& map : maps) {
    if (!map.has_position()) continue;
    const Georeference& g = *map.georeference;
    information += static_cast<double>(g.inliers.size()) /
                   (g.sigma_horizontal * g.sigma_horizontal * g.correlation_inflation);
  }
  return information;
}

// Moves all that GPS holds to where the robots' receivers have it, as far as they know better than
// the drone's. The solver alone would take long to move a stiff site by many sigmas of a good one.
void MoveToReceivers(const JointProblem& problem, JointSolution* solution) {
  const auto& fixes = *problem.robot_positions;
  std::vector<double> off[3];
  double information = 0.0;
  for (const RobotPosition& fix : fixes) {
    if (!problem.placement->placed[fix.scan]) continue;
    const Eigen::Vector3d difference =
        fix.position - solution->world_from_scan[fix.scan] * fix.antenna;
    for (int k = 0; k < 3; ++k) off[k].push_back(difference[k]);
    information += 1.0 / (fix.sigma * fix.sigma * fix.inflation);
  }
  if (off[0].empty()) return;
  const double share = information / (information + CameraInformation(*problem.maps));
  const Eigen::Vector3d shift =
      share * Eigen::Vector3d(Median(off[0]), Median(off[1]), Median(off[2]));
  for (std::size_t i = 0; i < solution->world_from_scan.size(); ++i) {
    if (problem.placement->placed[i]) solution->world_from_scan[i].translation += shift;
  }
  for (Sim3& map : solution->world_from_metric) map.translation += shift;
}

Rest RestOf(const JointProblem& problem, const MapOptions& options,
            const AssociationOptions& association) {
  Rest rest;
  rest.last_gate = std::max(kLastGate, kFloorGate * association.floor_offset);
  // Below what the scans disagree by, a pose's move means nothing; nor, between scans that a map
  // joins, below what its blocks do.
  rest.stable = rest.stable_in_map = std::max(options.stable, association.floor_offset);
  for (const auto& errors : problem.placement->errors) {
    rest.stable_in_map = std::max(rest.stable_in_map, errors.block_sigma);
  }
  rest.joined = Components(problem.scans->size(), *problem.pairs);
  rest.component = Components(problem.scans->size(), *problem.pairs, *problem.map_pairs);
  return rest;
}

// Directions (world) that every used registration of a scan leaves open.
std::vector<std::vector<Eigen::Vector3d>> OpenDirections(const std::vector<PairRecord>& pairs,
                                                         const std::vector<Rigid3>& poses) {
  std::vector<std::vector<Eigen::Vector3d>> open(poses.size());
  std::vector<bool> first(poses.size(), true);
  const auto meet = [&](std::size_t scan, const std::vector<Eigen::Vector3d>& directions) {
    if (first[scan]) open[scan] = directions;
    std::erase_if(open[scan], [&](const Eigen::Vector3d& v) {
      return std::none_of(directions.begin(), directions.end(),
                          [&](const Eigen::Vector3d& w) { return std::abs(v.dot(w)) > 0.98; });
    });
    first[scan] = false;
  };
  for (const auto& pair : pairs) {
    if (!pair.used) continue;
    std::vector<Eigen::Vector3d> directions;
    for (const auto& d : pair.registration.unobserved) {
      if (d.direction.head<3>().norm() > 0.5) {
        directions.push_back(poses[pair.target].rotation * d.direction.head<3>());
      }
    }
    meet(pair.target, directions);
    meet(pair.source, directions);
  }
  return open;
}

// Turns normals that are nearly across an open direction fully across it, so that they carry no
// information along it.
void RemoveFakedInformation(const std::vector<std::vector<Eigen::Vector3d>>& open, Graph* graph) {
  for (auto& plane : graph->planes) {
    for (const auto& seen : plane.observations) {
      if (seen.map >= 0) continue;
      for (const Eigen::Vector3d& v : open[seen.pose]) {
        const double along = plane.normal.dot(v);
        if (std::abs(along) < kAcross) plane.normal = (plane.normal - along * v).normalized();
      }
    }
  }
}

// Scans that maps alone join have no plane in common to make an edge of: one edge for each such
// gap, with the covariance of the whole graph.
std::vector<MarginalEdge> Bridges(const MapResult& result, const std::vector<PairRecord>& pairs,
                                  const GraphCovariance& covariance) {
  const std::vector<int> alone = Components(result.scans.size(), pairs);
  std::map<int, std::size_t> first;  // of each component, maps included
  std::set<int> bridged;
  std::vector<MarginalEdge> bridges;
  for (std::size_t i = 0; i < alone.size(); ++i) {
    if (!bridged.insert(alone[i]).second) continue;
    const auto [anchor, is_first] = first.try_emplace(result.component[i], i);
    if (is_first) continue;
    const int target = static_cast<int>(anchor->second), source = static_cast<int>(i);
    const Matrix6d relative = covariance.Relative(target, source);
    if (!relative.allFinite()) continue;
    bridges.push_back({target, source,
                       result.solution.world_from_scan[target].Inverse() *
                           result.solution.world_from_scan[source],
                       PositiveInverse(relative)});
  }
  return bridges;
}

}  // namespace

std::vector<int> Components(std::size_t scans, const std::vector<PairRecord>& pairs,
                            const std::vector<MapPairRecord>& map_pairs) {
  std::size_t nodes = scans;
  for (const auto& pair : map_pairs) nodes = std::max(nodes, scans + pair.map + 1);
  DisjointSets sets(nodes);
  for (const auto& pair : pairs) {
    if (pair.used) sets.Join(pair.target, pair.source);
  }
  for (const auto& pair : map_pairs) {
    if (pair.used) sets.Join(pair.scan, scans + pair.map);
  }
  std::vector<int> number(nodes, -1), component(scans);
  int next = 0;
  for (std::size_t i = 0; i < scans; ++i) {
    int& n = number[sets.Find(i)];
    if (n < 0) n = next++;
    component[i] = n;
  }
  return component;
}

std::vector<Rigid3> ChainPoses(const Site& site, const std::vector<ScanRecord>& scans,
                               const std::vector<PairRecord>& pairs,
                               const std::vector<OdometryStep>& odometry) {
  std::vector<Rigid3> poses(scans.size());
  for (std::size_t i = 0; i < scans.size(); ++i) {
    const RobotSite& robot = site.robots[scans[i].robot];
    if (IsFirstOfRobot(scans, i)) {
      if (robot.start) poses[i] = robot.start->world_from_scan;
      continue;
    }
    Rigid3 step;
    for (const auto& s : odometry) {
      if (s.source == i) step = s.target_from_source;
    }
    for (const auto& pair : pairs) {
      if (pair.used && pair.source == i && pair.target == i - 1) {
        step = pair.registration.target_from_source();
      }
    }
    poses[i] = poses[i - 1] * step;
  }
  return poses;
}

JointSolution SolveJointly(const JointProblem& problem, const MapOptions& options) {
  const auto begin = std::chrono::steady_clock::now();
  const Placement& placement = *problem.placement;
  JointSolution solution;
  solution.world_from_scan = placement.world_from_scan;
  solution.world_from_metric = placement.world_from_metric;
  MapWeights weights = WeighMaps(problem);
  MoveToReceivers(problem, &solution);
  solution.bent_maps = LayOutTiles(problem, solution);
  AssociationOptions association = MeasuredAssociation(problem);
  association.gate = kFirstGate;
  const Rest rest = RestOf(problem, options, association);
  const auto judgement =
      IsGraduated(PlaneLoss(options)) ? std::make_unique<GroupJudgement>(problem) : nullptr;
  // The last solve may find that the quick ones before it had only come to rest too early.
  do {
    Rounds(problem, options, rest, &weights, &association, &solution, judgement.get());
  } while (!FinishSolve(problem, options, rest, &solution) &&
           solution.rounds < options.most_rounds);
  ListSwitchedOff(problem, options, judgement.get(), &solution);
  solution.floor_offset = association.floor_offset;
  solution.floor_tilt = association.floor_tilt;
  solution.seconds =
      std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  return solution;
}

void ComputeUncertainty(const std::vector<PairRecord>& pairs, const MapOptions& options,
                        MapResult* result) {
  Graph graph = result->solution.graph;
  RemoveFakedInformation(OpenDirections(pairs, result->solution.world_from_scan), &graph);
  std::erase_if(graph.pose_factors, [](const PoseFactor& f) { return f.source == "hold"; });
  ShareOdometryScales(result->odometry, result->site.robots.size(), &graph);
  CovarianceOptions limits;
  limits.noise = options.covariance;
  limits.translation_threshold = options.registration.weak_translation;
  limits.rotation_threshold = options.registration.weak_rotation;
  result->covariance =
      std::make_shared<GraphCovariance>(graph, RoundOptions(options, true), limits);
  const GraphCovariance& covariance = *result->covariance;
  for (int i = 0; i < static_cast<int>(graph.poses.size()); ++i) {
    result->covariances.push_back(covariance.Pose(i));
    result->unobserved.push_back(covariance.Unobserved(i));
  }
  ComputeMapCovariances(covariance, result);
  result->odometry_scale_sigmas.assign(result->site.robots.size(), 0.0);
  for (int s = 0; s < static_cast<int>(graph.scales.size()); ++s) {
    result->odometry_scale_sigmas[std::stoul(graph.scales[s].id)] = std::sqrt(covariance.Scale(s));
  }
  if (Components(result->scans.size(), pairs) == result->component) return;
  // Like the other edges of the graph that is written: by the stated noise.
  limits.noise = CovarianceNoise::kStated;
  result->bridges =
      Bridges(*result, pairs, GraphCovariance(graph, RoundOptions(options, true), limits));
}

}  // namespace planegraph
