#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "planegraph/geometry/plane.h"
#include "planegraph/geometry/rigid3.h"
#include "planegraph/simulation/laser_scanner.h"
#include "planegraph/simulation/odometry.h"
#include "planegraph/simulation/scene.h"

namespace planegraph {

struct SimulationOptions {
  SceneKind scene = SceneKind::kYard;
  std::uint64_t seed = 0;  ///< of the scene, the drive and all noise
  int scans = 0;           ///< 0: as many as suit the scene; at most 1000
  int threads = 0;         ///< 0: all cores; the result is the same for each number
  ScannerOptions scanner;
  PoseOptions pose;
  OdometryOptions odometry;
};

/// A site with exact truth. Entry k of each list belongs to scan k.
struct SimulatedSite {
  std::string name;
  std::vector<LabelledScan> scans;
  std::vector<double> times;     ///< seconds, increasing
  std::vector<Rigid3> truth;     ///< world_from_scan
  std::vector<Rigid3> odometry;  ///< odometry_from_scan, the first identity
  /// Of the scene, world frame; index = label of a point. Normals point out of the solids, which is
  /// the side seen.
  std::vector<Plane> planes;
};

/// Builds the scene, drives through it and scans. The result depends on the options alone. Throws
/// UsageError for options that make no sense.
SimulatedSite Simulate(const SimulationOptions& options);

/// Writes a site as a folder that `planegraph map FOLDER/site.yaml` takes: scans/scanNNN.ply (float
/// x y z), odometry.tum, truth.tum, and beside them truth/planes.json (`planes[]` with id, normal,
/// distance) and truth/labels/scanNNN.ply (the same points with an int property `plane`, -1: none).
/// Left-over scans of an earlier, longer run in that folder are removed. Throws InputError.
void WriteSite(const std::string& folder, const SimulatedSite& site);

}  // namespace planegraph
