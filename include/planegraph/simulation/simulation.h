#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "planegraph/geometry/plane.h"
#include "planegraph/geometry/rigid3.h"
#include "planegraph/simulation/drone.h"
#include "planegraph/simulation/laser_scanner.h"
#include "planegraph/simulation/odometry.h"
#include "planegraph/simulation/scene.h"

namespace planegraph {

enum class DroneMode {
  kAuto,  ///< where a scene is out of doors: yard and quarter
  kOn,
  kOff
};

/// "auto", "on" or "off". Throws UsageError for other names.
DroneMode ParseDroneMode(const std::string& name);

struct SimulationOptions {
  SceneKind scene = SceneKind::kYard;
  std::uint64_t seed = 0;  ///< of the scene, the drives and all noise
  int scans = 0;           ///< of each robot; 0: as many as suit the scene; at most 1000
  int threads = 0;         ///< 0: all cores; the result is the same for each number
  ScannerOptions scanner;
  PoseOptions pose;
  OdometryOptions odometry;
  DroneMode drone_mode = DroneMode::kAuto;
  DroneOptions drone;
};

/// A robot's data with exact truth. Entry k of each list belongs to scan k.
struct SimulatedRobot {
  std::string name;
  std::vector<LabelledScan> scans;
  std::vector<double> times;         ///< seconds, increasing
  std::vector<Rigid3> truth;         ///< world_from_scan
  std::vector<Rigid3> odometry;      ///< odometry_from_scan, the first identity
  OdometryOptions odometry_options;  ///< what it was made with
  /// Roughly where the first scan was taken (world_from_scan): level, and within 1 m on each axis
  /// and 10 degrees of heading. Present where there is a drone, which ties the world to the earth.
  std::optional<Rigid3> start;
  /// Fixes of the antenna on its mast, world frame; empty without a drone.
  SimulatedGps gps;
};

/// Where a robot carries its antenna, scan's frame, metres.
inline const Eigen::Vector3d kAntenna{-0.3, 0.1, 0.4};

/// A site with exact truth.
struct SimulatedSite {
  std::string name;
  std::vector<SimulatedRobot> robots;  ///< at least one
  std::optional<SimulatedDrone> drone;
  /// Of the scene, world frame; index = label of a point. Normals point out of the solids, which is
  /// the side seen.
  std::vector<Plane> planes;
};

/// Builds the scene, drives through it and scans, and flies over it. The result depends on the
/// options alone. Throws UsageError for options that make no sense.
SimulatedSite Simulate(const SimulationOptions& options);

/// Writes a site as a folder that `planegraph map FOLDER/site.yaml` takes: scans/scanNNN.ply (float
/// x y z), odometry.tum, truth.tum, and beside them truth/planes.json (`planes[]` with id, normal,
/// distance) and truth/labels/scanNNN.ply (the same points with an int property `plane`, -1: none).
/// With several robots these lie in ROBOT/ and truth/labels/ROBOT/. With a drone, the files of
/// WriteDrone, gps.csv of each robot, and site_nostart.yaml (no start poses), site_gps.yaml (no
/// start poses, but the robots' GPS) and site_laser_only.yaml (no drone either).
/// What an earlier, larger run left in that folder is removed. Throws InputError.
void WriteSite(const std::string& folder, const SimulatedSite& site);

}  // namespace planegraph
