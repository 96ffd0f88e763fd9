#pragma once

#include <string>
#include <vector>

#include "io/test_files.h"
#include "planegraph/io/cloud_io.h"
#include "planegraph/pipeline/mapper.h"
#include "planegraph/simulation/simulation.h"

namespace planegraph {

/// A simulated site of few and coarse scans, a second's work: the first `scans` of a drive that
/// would be `of` scans long, so that neighbours overlap.
inline SimulatedSite SmallSite(SceneKind kind, int scans, int of, std::uint64_t seed = 1) {
  ScannerOptions scanner;
  scanner.beams = 361;
  scanner.sweeps = 120;
  const Scene scene = BuildScene(kind, seed, scanner.max_range);
  const RayCaster caster(scene.mesh);
  SimulatedSite site;
  site.name = SceneName(kind);
  site.planes = scene.mesh.planes;
  SimulatedRobot& robot = site.robots.emplace_back();
  robot.name = "robot1";
  robot.truth = DrivePath(scene, caster, of, {}, seed);
  robot.truth.resize(scans);
  for (int i = 0; i < scans; ++i) {
    Random noise(seed, static_cast<std::uint64_t>(i + 1));
    robot.scans.push_back(Scan(caster, robot.truth[i], scanner, &noise));
    robot.times.push_back(10.0 * i);
  }
  Random drift(seed, 1000);
  robot.odometry = SimulateOdometry(robot.truth, {}, &drift);
  return site;
}

inline MapOptions TwoThreads(const std::string& optimizer = "graph") {
  MapOptions options;
  options.optimizer = optimizer;
  options.threads = 2;
  return options;
}

/// The true poses in the frame of the first scan, which is the world of `planegraph map`.
inline std::vector<Rigid3> TruthFromFirst(const SimulatedSite& site) {
  std::vector<Rigid3> poses;
  const std::vector<Rigid3>& truth = site.robots.front().truth;
  for (const Rigid3& pose : truth) poses.push_back(truth.front().Inverse() * pose);
  return poses;
}

/// Largest distance between positions of equal index.
inline double LargestDistance(const std::vector<Rigid3>& a, const std::vector<Rigid3>& b) {
  double largest = 0.0;
  for (std::size_t i = 0; i < a.size(); ++i) {
    largest = std::max(largest, (a[i].translation - b[i].translation).norm());
  }
  return largest;
}

}  // namespace planegraph
