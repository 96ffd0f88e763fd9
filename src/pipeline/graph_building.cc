#include "pipeline/graph_building.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <map>
#include <set>

#include "pipeline/open_directions.h"
#include "pipeline/tiled_graph.h"
#include "planegraph/base/median.h"

namespace planegraph {
namespace {

std::vector<const PlaneSet*> PlaneSets(const std::vector<ScanRecord>& scans) {
  std::vector<const PlaneSet*> sets;
  for (const auto& scan : scans) sets.push_back(&scan.planes);
  return sets;
}

// Neighbouring surfaces of a map err together: the observations of one block have the information
// of its mean, whatever their number.
void ShareMapInformation(const MapWeights& weights, Graph* graph) {
  std::map<std::pair<int, std::uint64_t>, double> count;
  const auto block = [](const PlaneLandmark& plane, const PlaneObservation& seen) {
    return std::pair(seen.map, MapBlock(plane.anchor, plane.normal));
  };
  for (const auto& plane : graph->planes) {
    for (const auto& seen : plane.observations) {
      if (seen.map >= 0) count[block(plane, seen)] += 1.0;
    }
  }
  for (auto& plane : graph->planes) {
    for (auto& seen : plane.observations) {
      if (seen.map < 0) continue;
      const double shared = weights.errors[seen.map].block_sigma;
      const double own = 1.0 / (seen.offset_weight * seen.offset_weight);
      const double variance =
          weights.factors[seen.map] * std::max(own, count[block(plane, seen)] * shared * shared);
      const double share = std::sqrt(own / variance);
      seen.offset_weight *= share;
      seen.tilt_weight_1 *= share;
      seen.tilt_weight_2 *= share;
    }
  }
}

// Positions of the cameras of a map by GPS. The errors of a flight are correlated: together they
// are to say as much of the scale as the georeference found.
void AddCameraPositions(const MapRecord& map, int index, Graph* graph) {
  const Georeference& g = *map.georeference;
  // A scale that the user doubts more than the positions' noise says: their errors are systematic.
  const double doubt = std::max(1.0, std::pow(map.sigma_scale / std::max(g.sigma_scale, 1e-9), 2));
  const double inflation = g.correlation_inflation * doubt;
  Eigen::Vector3d variance(g.sigma_horizontal, g.sigma_horizontal, g.sigma_vertical);
  variance = variance.cwiseAbs2() * inflation;
  for (const CameraFix& fix : g.fixes) {
    if (!fix.inlier) continue;
    MapFactor factor;
    factor.maps = {index};
    factor.point = map.metric_from_map * fix.centre_in_map;
    factor.position = fix.position_in_world;
    factor.information.setZero();
    factor.information.diagonal().head<3>() = variance.cwiseInverse();
    factor.robust = true;
    graph->map_factors.push_back(std::move(factor));
  }
}

// A robot's start, beside a map that GPS places.
void AddStarts(const JointProblem& problem, Graph* graph) {
  for (std::size_t i = 0; i < problem.scans->size(); ++i) {
    const ScanRecord& scan = (*problem.scans)[i];
    const auto& start = problem.site->robots[scan.robot].start;
    if (!IsFirstOfRobot(*problem.scans, i) || !start || graph->poses[i].fixed) continue;
    Matrix6d information = Matrix6d::Zero();
    information.diagonal().head<3>().setConstant(std::pow(start->sigma_translation, -2));
    information.diagonal().tail<3>().setConstant(std::pow(start->sigma_rotation, -2));
    PoseFactor factor = MakePosePrior(static_cast<int>(i), start->world_from_scan, information);
    factor.robust = true;
    graph->pose_factors.push_back(std::move(factor));
  }
}

// Positions of the robots by GPS, where a map that GPS places holds them: elsewhere the first scan
// is the gauge and does not lie on the earth.
void AddRobotPositions(const JointProblem& problem, const std::set<int>& held,
                       const std::vector<int>& component, Graph* graph) {
  for (const RobotPosition& fix : *problem.robot_positions) {
    if (!held.count(component[fix.scan])) continue;
    PoseFactor factor;
    factor.type = "robot_position";
    factor.poses = {static_cast<int>(fix.scan)};
    factor.point = fix.antenna;
    factor.measurement.translation = fix.position;
    // Heights are worse: the satellites are all above.
    constexpr double kVertical = 1.5;
    const double horizontal = fix.sigma * fix.sigma * fix.inflation;
    factor.information.setZero();
    factor.information.diagonal().head<3>() =
        Eigen::Vector3d(1.0, 1.0, 1.0 / (kVertical * kVertical)) / horizontal;
    factor.source = "gps";
    factor.robust = true;
    graph->pose_factors.push_back(std::move(factor));
  }
}

// The vertical in a first scan's frame: what the scans say under their present poses, whose errors
// average out.
Eigen::Vector3d UpAsSeen(const JointProblem& problem, const Graph& graph) {
  Eigen::Vector3d up = Eigen::Vector3d::Zero();
  for (std::size_t i = 0; i < problem.scans->size(); ++i) {
    const auto& gravity = problem.site->robots[(*problem.scans)[i].robot].gravity;
    if (gravity) up += graph.poses[i].world_from_node.rotation * gravity->up;
  }
  return up.norm() > 1e-6 ? Eigen::Vector3d(up.normalized()) : Eigen::Vector3d::UnitZ();
}

// Where GPS holds a component, the world is the east-north-up frame.
void AddGravity(const JointProblem& problem, const std::set<int>& held,
                const std::vector<int>& component, Graph* graph) {
  const Eigen::Vector3d on_earth = Eigen::Vector3d::UnitZ();
  const Eigen::Vector3d as_seen = UpAsSeen(problem, *graph);
  for (std::size_t i = 0; i < problem.scans->size(); ++i) {
    const auto& gravity = problem.site->robots[(*problem.scans)[i].robot].gravity;
    if (!gravity || graph->poses[i].fixed) continue;
    PoseFactor factor;
    factor.type = "gravity";
    factor.poses = {static_cast<int>(i)};
    factor.point = gravity->up;
    factor.measurement.translation = held.count(component[i]) > 0 ? on_earth : as_seen;
    factor.information.setZero();
    factor.information.diagonal().tail<3>().setConstant(std::pow(gravity->sigma, -2));
    factor.source = "gravity";
    factor.robust = true;
    graph->pose_factors.push_back(std::move(factor));
  }
}

// A map's direction upwards is given in its own frame; the node's is the metric one.
void AddMapGravity(const JointProblem& problem, Graph* graph) {
  for (std::size_t m = 0; m < problem.maps->size(); ++m) {
    const MapRecord& map = (*problem.maps)[m];
    const auto& gravity = problem.site->maps[m].gravity;
    if (!gravity || !map.has_position() || graph->maps[m].fixed) continue;
    MapFactor factor;
    factor.type = "map_gravity";
    factor.maps = {static_cast<int>(m)};
    factor.point = map.metric_from_map.rotation * gravity->up;
    factor.position = Eigen::Vector3d::UnitZ();
    factor.information.setZero();
    factor.information.diagonal().segment<3>(3).setConstant(std::pow(gravity->sigma, -2));
    factor.source = "gravity";
    factor.robust = true;
    graph->map_factors.push_back(std::move(factor));
  }
}

// The components that a map holds which GPS places.
std::set<int> HeldComponents(const JointProblem& problem, const std::vector<int>& component) {
  std::set<int> held;
  for (const auto& pair : *problem.map_pairs) {
    if (pair.used && (*problem.maps)[pair.map].has_position()) held.insert(component[pair.scan]);
  }
  return held;
}

// The first scan of each component is its gauge, unless such a map holds it.
void SetGauge(std::set<int> held, const std::vector<int>& component, Graph* graph) {
  for (std::size_t i = 0; i < component.size(); ++i) {
    graph->poses[i].fixed = held.insert(component[i]).second;
  }
}

// A scan that was not registered to a map takes no part in that map's observations: what lies near
// its surfaces by chance (the outside of a hall that it stands in) is not what it saw.
void KeepAnchoredOnly(const JointProblem& problem, Graph* graph) {
  std::set<std::pair<int, int>> anchored;
  for (const auto& pair : *problem.map_pairs) {
    if (pair.used) anchored.insert({static_cast<int>(pair.map), static_cast<int>(pair.scan)});
  }
  for (auto& plane : graph->planes) {
    std::erase_if(plane.observations, [&](const PlaneObservation& seen) {
      return seen.map >= 0 &&
             std::none_of(plane.observations.begin(), plane.observations.end(),
                          [&](const PlaneObservation& other) {
                            return other.map < 0 && anchored.count({seen.map, other.pose});
                          });
    });
  }
  std::erase_if(graph->planes, [](const auto& plane) { return plane.observations.size() < 2; });
}

// Landmarks of each component by itself: scans that nothing joins may lie on each other by chance.
std::vector<PlaneLandmark> AssociateComponents(const JointProblem& problem,
                                               const JointSolution& solution,
                                               const AssociationOptions& association,
                                               const std::vector<PlacedMap>& maps) {
  static const PlaneSet kNone;
  const std::vector<int> component =
      Components(problem.scans->size(), *problem.pairs, *problem.map_pairs);
  std::vector<PlaneLandmark> landmarks;
  for (const int wanted : std::set<int>(component.begin(), component.end())) {
    std::vector<const PlaneSet*> sets = PlaneSets(*problem.scans);
    for (std::size_t i = 0; i < sets.size(); ++i) {
      if (component[i] != wanted) sets[i] = &kNone;
    }
    std::vector<PlacedMap> placed = maps;
    for (auto& map : placed) map.planes = &kNone;
    for (const auto& pair : *problem.map_pairs) {
      if (pair.used && component[pair.scan] == wanted) placed[pair.map] = maps[pair.map];
    }
    auto found = AssociatePatches(sets, solution.world_from_scan, association, placed);
    std::move(found.begin(), found.end(), std::back_inserter(landmarks));
  }
  return landmarks;
}

// The maps as nodes, those that no scan is registered to held; with their positions by GPS.
std::vector<PlacedMap> AddMaps(const JointProblem& problem, const JointSolution& solution,
                               Graph* graph) {
  std::set<std::size_t> used;
  for (const auto& pair : *problem.map_pairs) {
    if (pair.used) used.insert(pair.map);
  }
  std::vector<PlacedMap> placed;
  for (std::size_t m = 0; m < problem.maps->size(); ++m) {
    const MapRecord& map = (*problem.maps)[m];
    graph->maps.push_back(
        {map.id, solution.world_from_metric[m], !used.count(m), static_cast<int>(m)});
    placed.push_back({&map.planes, solution.world_from_metric[m], PlaceInTiles(solution, m)});
    if (used.count(m) && map.has_position()) AddCameraPositions(map, static_cast<int>(m), graph);
  }
  return placed;
}

PoseFactor FactorOf(const OdometryStep& step, const Matrix6d& covariance) {
  return MakeRelativePose(static_cast<int>(step.target), static_cast<int>(step.source),
                          step.target_from_source, PositiveInverse(covariance), "odometry");
}

}  // namespace

Matrix6d PositiveInverse(const Matrix6d& covariance) {
  return (covariance + 1e-12 * Matrix6d::Identity()).inverse();
}

std::vector<Rigid3> PosesOf(const Graph& graph) {
  std::vector<Rigid3> poses;
  for (const auto& node : graph.poses) poses.push_back(node.world_from_node);
  return poses;
}

void AddOdometry(const std::vector<OdometryStep>& odometry, Graph* graph, bool robust) {
  for (const auto& step : odometry) {
    graph->pose_factors.push_back(FactorOf(step, step.covariance));
    graph->pose_factors.back().robust = robust;
  }
}

void ShareOdometryScales(const std::vector<OdometryStep>& odometry, std::size_t robots,
                         Graph* graph) {
  std::erase_if(graph->pose_factors,
                [](const PoseFactor& factor) { return factor.source == "odometry"; });
  std::vector<double> sigmas(robots);
  for (const OdometryStep& step : odometry) sigmas[step.robot] = step.sigma_scale;
  std::vector<int> nodes(robots, -1);
  for (std::size_t r = 0; r < robots; ++r) {
    if (!(sigmas[r] > 0.0)) continue;
    nodes[r] = static_cast<int>(graph->scales.size());
    graph->scales.push_back({std::to_string(r)});
    graph->pose_factors.push_back(MakeScalePrior(nodes[r], 1.0, sigmas[r]));
  }
  for (const OdometryStep& step : odometry) {
    PoseFactor factor = FactorOf(step, step.OwnCovariance());
    factor.scale = nodes[step.robot];
    if (factor.scale >= 0) factor.type = "odometry_step";
    factor.robust = true;
    graph->pose_factors.push_back(factor);
  }
}

MapWeights WeighMaps(const JointProblem& problem) {
  MapWeights weights{problem.placement->errors, {}};
  for (std::size_t m = 0; m < problem.maps->size(); ++m) {
    weights.factors.push_back(MapVarianceFactor(*problem.map_pairs, *problem.placement, m));
    if (!problem.site->maps[m].tiles) continue;
    // As a rigid body a bent map errs more than its tiles will.
    weights.errors[m].block_sigma = MapErrors().block_sigma;
    weights.factors[m] = 1.0;
  }
  return weights;
}

AssociationOptions MeasuredAssociation(const JointProblem& problem) {
  std::vector<double> offsets, tilts;
  for (const auto& pair : *problem.pairs) {
    if (!pair.used) continue;
    offsets.push_back(pair.registration.refinement.floor);
    tilts.push_back(pair.registration.refinement.tilt_floor);
  }
  AssociationOptions options;
  // The floors were measured between two scans; each has its share.
  options.floor_offset = std::max(1e-3, Median(offsets, 2e-3) / std::sqrt(2.0));
  options.floor_tilt = std::max(5e-4, Median(tilts) / std::sqrt(2.0));
  AllowForMaps(problem.placement->errors, &options);
  return options;
}

void AllowForMaps(const std::vector<MapErrors>& maps, AssociationOptions* options) {
  const AssociationOptions least;
  options->map_gate = least.map_gate;
  options->map_floor_offset = least.map_floor_offset;
  for (const MapErrors& errors : maps) {
    options->map_gate = std::max(options->map_gate, 4.0 * errors.sigma);
    options->map_floor_offset = std::max(options->map_floor_offset, errors.sigma);
  }
}

Graph BuildGraph(const JointProblem& problem, const JointSolution& solution,
                 const AssociationOptions& association, const MapWeights& weights) {
  Graph graph;
  for (std::size_t i = 0; i < solution.world_from_scan.size(); ++i) {
    graph.poses.push_back({std::to_string(i), solution.world_from_scan[i], false});
  }
  const std::vector<int> component =
      Components(problem.scans->size(), *problem.pairs, *problem.map_pairs);
  const std::set<int> held = HeldComponents(problem, component);
  SetGauge(held, component, &graph);
  const std::vector<PlacedMap> placed = AddMaps(problem, solution, &graph);
  graph.planes = AssociateComponents(problem, solution, association, placed);
  KeepAnchoredOnly(problem, &graph);
  ShareMapInformation(weights, &graph);
  AddOdometry(*problem.odometry, &graph);
  HoldOpenDirections(problem, solution, &graph);
  AddStarts(problem, &graph);
  AddRobotPositions(problem, held, component, &graph);
  AddGravity(problem, held, component, &graph);
  AddMapGravity(problem, &graph);
  return graph;
}

}  // namespace planegraph
