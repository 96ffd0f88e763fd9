#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <string>
#include <vector>

#include "planegraph/geometry/rigid3.h"
#include "planegraph/simulation/labelled_mesh.h"
#include "planegraph/simulation/random.h"
#include "planegraph/simulation/ray_caster.h"

namespace planegraph {

enum class SceneKind {
  kHall,      ///< a large hall with columns, machines and adjoining rooms; a closed loop
  kCorridor,  ///< straight along x and without any feature along it; ends out of the range
  kYard,      ///< buildings around sloping ground, and a hall that the robot drives into
  kQuarter    ///< a town quarter with two streets, each the drive of a robot of its own
};

/// "hall", "corridor", "yard" or "quarter". Throws UsageError for other names.
SceneKind ParseSceneKind(const std::string& name);
std::string SceneName(SceneKind kind);

/// The way of one robot.
struct Drive {
  std::string robot = "robot1";
  std::vector<Eigen::Vector2d> path;  ///< corners, metres
  int scans = 8;                      ///< how many scans suit it
};

/// What there is to be scanned, and where robots drive. World frame, z up, metres.
struct Scene {
  LabelledMesh mesh;
  std::vector<Drive> drives;  ///< at least one
  double probe_height = 2.0;  ///< above everything a robot drives on, below every roof over it
  /// Two corners of the ground plan of what matters, for a drone to fly over.
  Eigen::Vector2d area_low = Eigen::Vector2d::Zero(), area_high = Eigen::Vector2d::Zero();
};

/// The scene of a seed: sizes and furniture vary with it. `max_range` (metres) is the sensor's, for
/// the corridor's ends to lie beyond it.
Scene BuildScene(SceneKind kind, std::uint64_t seed, double max_range);

/// How the robot stands.
struct PoseOptions {
  double mount_height = 0.78;      ///< of the scanner above the ground, metres
  double lateral_sigma = 0.08;     ///< of the position beside the path, metres (cut off at 3 sigma)
  double heading_sigma = 0.07;     ///< of the heading against the path, radians
  double tilt_sigma = 0.007;       ///< of roll and pitch against the ground, radians
  double strong_tilt = 0.07;       ///< largest tilt of a scan taken on some obstacle, radians
  double strong_tilt_share = 0.2;  ///< share of such scans
};

/// `count` scanner poses (world_from_scan), evenly spread over the path of the scene's drive
/// `drive`, standing on the ground that `caster` finds. Throws NoResultError where there is no
/// ground.
std::vector<Rigid3> DrivePath(const Scene& scene, const RayCaster& caster, int count,
                              const PoseOptions& options, std::uint64_t seed,
                              std::size_t drive = 0);

}  // namespace planegraph
