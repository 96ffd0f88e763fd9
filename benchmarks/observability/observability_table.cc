// observability_table FOLDER [SITES [SEED]]: the table of docs/observability.md. Simulates sites
// into FOLDER, maps them, and compares the directions that the report calls open with those that
// the scene's true normals leave open.
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <map>
#include <set>
#include <string>
#include <vector>

#include "planegraph/pipeline/mapper.h"
#include "planegraph/simulation/simulation.h"
#include "planegraph/solve/covariance.h"

namespace planegraph {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

constexpr std::size_t kLeastPoints = 50;  // of a plane that a scan counts as having seen
constexpr double kFree = 1e-6;            // share of the normals' squares along a free direction
const double kSame = std::cos(10.0 * M_PI / 180.0);

// Orthonormal world axes along which (translations) or about which (rotations) a scan is free.
struct Axes {
  std::vector<Vector3d> translations, rotations;
};

// Whether an axis lies in the span of others.
bool Among(const std::vector<Vector3d>& axes, const Vector3d& axis) {
  double squares = 0.0;
  for (const Vector3d& other : axes) squares += std::pow(other.dot(axis), 2);
  return squares > kSame * kSame;
}

std::vector<std::set<int>> SeenPlanes(const SimulatedRobot& robot) {
  std::vector<std::set<int>> seen;
  for (const LabelledScan& scan : robot.scans) {
    std::map<int, std::size_t> points;
    for (const int label : scan.labels) ++points[label];
    seen.emplace_back();
    for (const auto& [label, count] : points) {
      if (label != kNotPlanar && count >= kLeastPoints) seen.back().insert(label);
    }
  }
  return seen;
}

// By the true normals of the planes that a scan shares with others that registrations join it to.
Axes TrulyFree(const SimulatedSite& site, const std::vector<std::set<int>>& seen,
               const std::vector<int>& component, std::size_t scan) {
  Matrix3d squares = Matrix3d::Zero();
  for (const int label : seen[scan]) {
    std::size_t scans = 0;
    for (std::size_t k = 0; k < seen.size(); ++k) {
      if (component[k] == component[scan]) scans += seen[k].count(label);
    }
    const Vector3d& normal = site.planes[label].normal;
    if (scans > 1) squares += normal * normal.transpose();
  }
  const Eigen::SelfAdjointEigenSolver<Matrix3d> solver(squares);
  Axes free;
  for (int k = 0; k < 3; ++k) {
    if (solver.eigenvalues()[k] > kFree * solver.eigenvalues()[2]) continue;
    free.translations.push_back(solver.eigenvectors().col(k));
  }
  if (free.translations.size() == 2) free.rotations.push_back(solver.eigenvectors().col(2));
  return free;
}

// Whether the motion moves the scan: the largest part is the rest, unless all are single scans.
bool Moves(const OpenMotion& motion, int scan) {
  for (std::size_t k = motion.parts[0].size() == 1 ? 0 : 1; k < motion.parts.size(); ++k) {
    for (const int node : motion.parts[k]) {
      if (node == scan) return true;
    }
  }
  return false;
}

Axes Found(const std::vector<OpenMotion>& motions, int scan, const Eigen::Quaterniond& to_truth) {
  Axes found;
  for (const OpenMotion& motion : motions) {
    if (motion.parts.size() < 2 || !Moves(motion, scan)) continue;
    const bool rotation = motion.kind == MotionKind::kRotation;
    for (const Vector3d& axis : motion.axes) {
      (rotation ? found.rotations : found.translations).push_back(to_truth * axis);
    }
  }
  return found;
}

struct Counts {
  int sites = 0, scans = 0, free = 0, found = 0, right = 0, missed = 0;

  void Compare(const std::vector<Vector3d>& truth, const std::vector<Vector3d>& axes) {
    free += static_cast<int>(truth.size());
    found += static_cast<int>(axes.size());
    for (const Vector3d& axis : axes) right += Among(truth, axis) ? 1 : 0;
    for (const Vector3d& axis : truth) missed += Among(axes, axis) ? 0 : 1;
  }
  void Add(const Counts& other) {
    sites += other.sites, scans += other.scans, free += other.free;
    found += other.found, right += other.right, missed += other.missed;
  }
};

Counts Measure(SceneKind scene, std::uint64_t seed, const std::string& folder) {
  SimulationOptions options;
  options.scene = scene;
  options.seed = seed;
  options.scans = 8;
  options.scanner.beams = 361;
  options.scanner.sweeps = 120;
  options.drone_mode = DroneMode::kOff;
  const SimulatedSite site = Simulate(options);
  WriteSite(folder, site);
  const MapOptions map_options;
  const MapResult result = MapScans(ReadSite(folder + "/site.yaml"), map_options);
  const auto motions = result.covariance->OpenMotions();
  const SimulatedRobot& robot = site.robots.front();
  const auto seen = SeenPlanes(robot);
  Counts counts{.sites = 1};
  for (std::size_t k = 0; k < robot.scans.size(); ++k) {
    // A scan that no registration joins shares nothing with the others.
    if (std::count(result.component.begin(), result.component.end(), result.component[k]) < 2) {
      continue;
    }
    ++counts.scans;
    const Eigen::Quaterniond to_truth =
        robot.truth[k].rotation * result.solution.world_from_scan[k].rotation.conjugate();
    const Axes truth = TrulyFree(site, seen, result.component, k);
    const Axes found = Found(motions, static_cast<int>(k), to_truth);
    counts.Compare(truth.translations, found.translations);
    counts.Compare(truth.rotations, found.rotations);
  }
  return counts;
}

std::string Share(int part, int of) {
  char text[16];
  std::snprintf(text, sizeof(text), "%.3f", part / static_cast<double>(of));
  return of > 0 ? text : "–";
}

void Print(const std::string& scene, const Counts& c) {
  std::printf("| %s | %d | %d | %d | %d | %s | %s |\n", scene.c_str(), c.sites, c.scans, c.free,
              c.found, Share(c.right, c.found).c_str(), Share(c.free - c.missed, c.free).c_str());
}

int Run(const std::string& folder, int sites, int first_seed) {
  std::printf(
      "| scene | sites | scans | truly free | found | precision | recall |\n"
      "|---|---|---|---|---|---|---|\n");
  Counts all;
  for (const SceneKind scene : {SceneKind::kCorridor, SceneKind::kHall, SceneKind::kYard}) {
    Counts counts;
    for (int k = 0; k < sites; ++k) {
      counts.Add(Measure(scene, static_cast<std::uint64_t>(first_seed + k), folder));
    }
    Print(SceneName(scene), counts);
    std::fflush(stdout);
    all.Add(counts);
  }
  Print("all", all);
  const double line = 0.95;
  return all.right >= line * all.found && all.free - all.missed >= line * all.free ? 0 : 3;
}

}  // namespace
}  // namespace planegraph

int main(int argc, char** argv) {
  if (argc < 2) return 1;
  const int sites = argc > 2 ? std::atoi(argv[2]) : 12, seed = argc > 3 ? std::atoi(argv[3]) : 0;
  return planegraph::Run(argv[1], sites, seed);
}
