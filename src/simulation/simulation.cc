#include "planegraph/simulation/simulation.h"

#include <algorithm>
#include <cmath>

#include "planegraph/base/error.h"
#include "planegraph/base/parallel.h"
#include "simulation/streams.h"

namespace planegraph {
namespace {

int CountScans(const SimulationOptions& options, const Drive& drive) {
  constexpr int kMostScans = 1000;  // three digits in the files' names
  if (options.scans < 0 || options.scans > kMostScans) {
    throw UsageError("the number of scans must lie in 1 to 1000 (0: the scene's own)");
  }
  return options.scans > 0 ? options.scans : drive.scans;
}

// The robot stands still for a scan and then drives on at half a metre per second.
std::vector<double> TimeStamps(const std::vector<Rigid3>& poses) {
  constexpr double kStart = 1000.0, kScanTime = 10.0, kSpeed = 0.5;
  std::vector<double> times(poses.size(), kStart);
  for (std::size_t k = 1; k < poses.size(); ++k) {
    const double way = (poses[k].translation - poses[k - 1].translation).norm();
    times[k] = times[k - 1] + kScanTime + way / kSpeed;
  }
  return times;
}

bool HasDrone(const SimulationOptions& options) {
  if (options.drone_mode != DroneMode::kAuto) return options.drone_mode == DroneMode::kOn;
  return options.scene == SceneKind::kYard || options.scene == SceneKind::kQuarter;
}

// What somebody who sets the robot down can say about its pose.
Rigid3 RoughStart(const Rigid3& truth, Random* random) {
  constexpr double kSigma = 0.5, kMost = 0.95, kMostTurn = 0.16;
  Rigid3 start = truth;
  for (int k = 0; k < 3; ++k) {
    start.translation[k] += std::clamp(kSigma * random->Normal(), -kMost, kMost);
  }
  const Eigen::Vector3d ahead = truth.rotation * Eigen::Vector3d::UnitX();
  const double heading = std::atan2(ahead.y(), ahead.x()) + random->Uniform(-kMostTurn, kMostTurn);
  start.rotation = Eigen::AngleAxisd(heading, Eigen::Vector3d::UnitZ());
  return start;
}

SimulatedGps SimulateRobotGps(const SimulatedRobot& robot, const GpsOptions& options,
                              Random* random) {
  Flight way;
  way.times = robot.times;
  for (const Rigid3& pose : robot.truth) {
    way.world_from_camera.push_back({pose.rotation, pose * kAntenna});
  }
  return SimulateGps(way, options, random);
}

SimulatedRobot SimulateRobot(const Scene& scene, const RayCaster& caster, std::size_t index,
                             const SimulationOptions& options) {
  const std::uint64_t streams = kStreamsPerRobot * index;
  SimulatedRobot robot;
  robot.name = scene.drives[index].robot;
  robot.truth = DrivePath(scene, caster, CountScans(options, scene.drives[index]), options.pose,
                          options.seed, index);
  robot.times = TimeStamps(robot.truth);
  Random odometry_random(options.seed, streams + kOdometryStream);
  robot.odometry_options = options.odometry;
  robot.odometry = SimulateOdometry(robot.truth, options.odometry, &odometry_random);
  Random start_random(options.seed, streams + kStartStream);
  if (HasDrone(options)) {
    robot.start = RoughStart(robot.truth.front(), &start_random);
    Random gps_random(options.seed, streams + kRobotGpsStream);
    robot.gps = SimulateRobotGps(robot, options.drone.gps, &gps_random);
  }
  robot.scans.resize(robot.truth.size());
  ParallelFor(robot.scans.size(), options.threads, [&](std::size_t k) {
    Random random(options.seed, streams + kFirstScanStream + k);
    robot.scans[k] = Scan(caster, robot.truth[k], options.scanner, &random);
  });
  return robot;
}

}  // namespace

DroneMode ParseDroneMode(const std::string& name) {
  if (name == "auto") return DroneMode::kAuto;
  if (name == "on") return DroneMode::kOn;
  if (name == "off") return DroneMode::kOff;
  throw UsageError("unknown drone mode '" + name + "' (auto, on or off)");
}

SimulatedSite Simulate(const SimulationOptions& options) {
  const Scene scene = BuildScene(options.scene, options.seed, options.scanner.max_range);
  const RayCaster caster(scene.mesh);
  SimulatedSite site;
  site.name = "simulated " + SceneName(options.scene) + ", seed " + std::to_string(options.seed);
  site.planes = scene.mesh.planes;
  for (std::size_t k = 0; k < scene.drives.size(); ++k) {
    site.robots.push_back(SimulateRobot(scene, caster, k, options));
  }
  if (HasDrone(options)) {
    site.drone = SimulateDrone(scene, caster, options.drone, options.seed, options.threads);
  }
  return site;
}

}  // namespace planegraph
