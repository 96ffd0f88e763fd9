#include "planegraph/pipeline/joint_solve.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <numeric>
#include <set>

#include "planegraph/solve/covariance.h"

namespace planegraph {
namespace {

constexpr double kFirstGate = 0.25, kLastGate = 0.05;  // metres
constexpr double kFloorGate = 4.0;   // the last gate is at least this many noise floors
constexpr double kHoldSigma = 1e-3;  // metres: how tightly odometry holds an open direction
const double kAcross = std::sin(3.0 * 3.14159265358979 / 180.0);

double MedianOf(std::vector<double> values, double fallback) {
  if (values.empty()) return fallback;
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

Graph PosesOnly(const std::vector<Rigid3>& poses, const std::vector<int>& component) {
  Graph graph;
  std::set<int> seen;
  for (std::size_t i = 0; i < poses.size(); ++i) {
    // Each component has a gauge of its own: its first scan.
    graph.poses.push_back({std::to_string(i), poses[i], seen.insert(component[i]).second});
  }
  return graph;
}

std::vector<Rigid3> PosesOf(const Graph& graph) {
  std::vector<Rigid3> poses;
  for (const auto& node : graph.poses) poses.push_back(node.world_from_node);
  return poses;
}

double LargestMove(const std::vector<Rigid3>& a, const std::vector<Rigid3>& b) {
  double move = 0.0;
  for (std::size_t i = 0; i < a.size(); ++i) {
    move = std::max(move, (a[i].translation - b[i].translation).norm());
  }
  return move;
}

Matrix6d PositiveInverse(const Matrix6d& covariance) {
  return (covariance + 1e-12 * Matrix6d::Identity()).inverse();
}

void AddOdometry(const std::vector<OdometryStep>& odometry, Graph* graph) {
  for (const auto& step : odometry) {
    PoseFactor factor =
        MakeRelativePose(static_cast<int>(step.target), static_cast<int>(step.source),
                         step.target_from_source, PositiveInverse(step.covariance), "odometry");
    factor.robust = true;
    graph->pose_factors.push_back(factor);
  }
}

// Along directions that the planes leave open the estimate shall follow the odometry, not what the
// noise of many normals adds up to.
void HoldOpenDirections(const std::vector<PairRecord>& pairs,
                        const std::vector<OdometryStep>& odometry, Graph* graph) {
  for (const PairRecord& pair : pairs) {
    if (!pair.used) continue;
    for (const auto& step : odometry) {
      if (step.target != pair.target || step.source != pair.source) continue;
      Matrix6d information = Matrix6d::Zero();
      for (const auto& open : pair.registration.unobserved) {
        if (open.direction.head<3>().norm() < 0.5) continue;
        information += open.direction * open.direction.transpose() / (kHoldSigma * kHoldSigma);
      }
      if (information.isZero()) continue;
      graph->pose_factors.push_back(MakeRelativePose(static_cast<int>(step.target),
                                                     static_cast<int>(step.source),
                                                     step.target_from_source, information, "hold"));
    }
  }
}

AssociationOptions FirstRound(const std::vector<PairRecord>& pairs) {
  std::vector<double> offsets, tilts;
  for (const auto& pair : pairs) {
    if (!pair.used) continue;
    offsets.push_back(pair.registration.refinement.floor);
    tilts.push_back(pair.registration.refinement.tilt_floor);
  }
  AssociationOptions options;
  // The floors were measured between two scans; each has its share.
  options.floor_offset = std::max(1e-3, MedianOf(offsets, 2e-3) / std::sqrt(2.0));
  options.floor_tilt = std::max(5e-4, MedianOf(tilts, 0.0) / std::sqrt(2.0));
  options.gate = kFirstGate;
  return options;
}

std::vector<const PlaneSet*> PlaneSets(const std::vector<ScanRecord>& scans) {
  std::vector<const PlaneSet*> sets;
  for (const auto& scan : scans) sets.push_back(&scan.planes);
  return sets;
}

SolveOptions RoundOptions(const MapOptions& options, bool last) {
  SolveOptions solve;
  solve.plane_factor = options.plane_factor;
  solve.plane_loss = options.loss;
  solve.pose_loss = ParseLoss("cauchy:2.4");
  // The rounds before the last only have to bring surfaces together that the next association then
  // pairs anew. Robust losses converge linearly; a millionth of the cost is microns of a pose.
  solve.max_iterations = last ? 25 : 5;
  solve.function_tolerance = last ? 1e-6 : 1e-4;
  solve.collect_residuals = last;
  return solve;
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
      for (const Eigen::Vector3d& v : open[seen.pose]) {
        const double along = plane.normal.dot(v);
        if (std::abs(along) < kAcross) plane.normal = (plane.normal - along * v).normalized();
      }
    }
  }
}

}  // namespace

std::vector<int> Components(std::size_t scans, const std::vector<PairRecord>& pairs) {
  std::vector<int> root(scans);
  std::iota(root.begin(), root.end(), 0);
  const auto find = [&](int i) {
    while (root[i] != i) i = root[i] = root[root[i]];
    return i;
  };
  for (const auto& pair : pairs) {
    if (!pair.used) continue;
    const int a = find(static_cast<int>(pair.target)), b = find(static_cast<int>(pair.source));
    root[std::max(a, b)] = std::min(a, b);
  }
  std::vector<int> number(scans, -1), component(scans);
  int next = 0;
  for (std::size_t i = 0; i < scans; ++i) {
    int& n = number[find(static_cast<int>(i))];
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
    if (scans[i].index == 0) {
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

std::vector<Rigid3> SolveRelativePoses(const std::vector<PairRecord>& pairs,
                                       const std::vector<OdometryStep>& odometry,
                                       std::vector<Rigid3> start, int) {
  Graph graph = PosesOnly(start, Components(start.size(), pairs));
  for (const auto& pair : pairs) {
    if (!pair.used) continue;
    PoseFactor factor =
        MakeRelativePose(static_cast<int>(pair.target), static_cast<int>(pair.source),
                         pair.registration.target_from_source(),
                         PositiveInverse(pair.registration.refinement.covariance), "registration");
    factor.robust = true;
    graph.pose_factors.push_back(factor);
  }
  AddOdometry(odometry, &graph);
  SolveOptions options;
  options.pose_loss = ParseLoss("cauchy:2.4");
  options.collect_residuals = false;
  options.max_iterations = 20;
  options.function_tolerance = 1e-4;  // a start for the association, no more
  if (graph.pose_factors.empty()) return start;
  Solve(&graph, options);
  return PosesOf(graph);
}

JointSolution SolveJointly(const std::vector<ScanRecord>& scans,
                           const std::vector<PairRecord>& pairs,
                           const std::vector<OdometryStep>& odometry,
                           const std::vector<Rigid3>& start, const MapOptions& options) {
  const auto begin = std::chrono::steady_clock::now();
  JointSolution solution;
  solution.world_from_scan = start;
  const std::vector<int> component = Components(scans.size(), pairs);
  const auto sets = PlaneSets(scans);
  AssociationOptions association = FirstRound(pairs);
  const double last_gate = std::max(kLastGate, kFloorGate * association.floor_offset);
  // Below what the scans disagree by, a pose's move means nothing.
  const double stable = std::max(options.stable, association.floor_offset);
  bool last = false;
  for (solution.rounds = 0; solution.rounds < options.most_rounds && !last; ++solution.rounds) {
    Graph graph = PosesOnly(solution.world_from_scan, component);
    graph.planes = AssociatePatches(sets, solution.world_from_scan, association);
    AddOdometry(odometry, &graph);
    HoldOpenDirections(pairs, odometry, &graph);
    solution.summary = Solve(&graph, RoundOptions(options, false));
    const std::vector<Rigid3> moved = PosesOf(graph);
    const double move = LargestMove(moved, solution.world_from_scan);
    last = association.gate <= last_gate && move < stable;
    solution.world_from_scan = moved;
    solution.graph = std::move(graph);
    association.gate = std::max(last_gate, 0.4 * association.gate);
    options.progress("solve", static_cast<double>(solution.rounds + 1) / options.most_rounds);
  }
  const double initial_cost = solution.summary.initial_cost;
  solution.summary = Solve(&solution.graph, RoundOptions(options, true));
  solution.summary.initial_cost = initial_cost;
  solution.last_move = LargestMove(PosesOf(solution.graph), solution.world_from_scan);
  // Robust losses creep on for long at surfaces that fit nowhere; what counts is that the poses
  // rest.
  solution.summary.converged |= solution.last_move < stable;
  solution.world_from_scan = PosesOf(solution.graph);
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
  CovarianceOptions limits;
  limits.translation_threshold = options.registration.weak_translation;
  limits.rotation_threshold = options.registration.weak_rotation;
  const GraphCovariance covariance(graph, RoundOptions(options, true), limits);
  for (int i = 0; i < static_cast<int>(graph.poses.size()); ++i) {
    result->covariances.push_back(covariance.Pose(i));
    result->unobserved.push_back(covariance.Unobserved(i));
  }
}

}  // namespace planegraph
