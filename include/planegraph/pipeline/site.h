#pragma once

#include <numbers>
#include <optional>
#include <string>
#include <vector>

#include "planegraph/cloud/filters.h"
#include "planegraph/geometry/rigid3.h"
#include "planegraph/io/local_frame.h"
#include "planegraph/io/trajectory_io.h"

namespace planegraph {

/// A start pose in the world frame with its standard deviations.
struct StartPose {
  Rigid3 world_from_scan;
  double sigma_translation = 1.0;  ///< metres, per axis
  double sigma_rotation = 0.17;    ///< radians, per axis
};

/// What a robot's receiver tells of its way.
struct RobotGps {
  std::string file;                                 ///< as for `georeference`, by time
  Eigen::Vector3d lever = Eigen::Vector3d::Zero();  ///< metres: the antenna in the scans' frame
  double sigma = 1.5;                               ///< metres, of one position and axis
};

/// The direction upwards in a frame, for levelled scanners and maps.
struct GravityPrior {
  Eigen::Vector3d up = Eigen::Vector3d::UnitZ();
  double sigma = 0.0087;  ///< radians
};

/// What a robot's odometry errs by from one scan to the next, standard deviations: of each axis of
/// the translation step + per_metre * length, of the rotation about each axis step_rotation +
/// per_turn * angle + rotation_per_metre * length; besides, all lengths are off by one factor
/// 1 + scale. The defaults are those of a tracked robot (ALGORITHMS 6.6): 5 % of the way in all.
struct OdometryNoise {
  double step = 0.02;  ///< metres
  double per_metre = 0.04;
  double scale = 0.03;                                  ///< relative
  double step_rotation = 0.5 * std::numbers::pi / 180;  ///< radians
  double per_turn = 0.05;
  double rotation_per_metre = 0.5 * std::numbers::pi / 180;  ///< radians per metre
};

/// A robot's scans in order, and what is known of its way.
struct RobotSite {
  std::string name;
  std::vector<std::string> scans;  ///< files
  std::string format = "auto";
  std::optional<Trajectory> odometry;  ///< as many poses as scans
  OdometryNoise odometry_noise = {};
  std::string odometry_file;  ///< that holds it; empty where .pose files do
  std::optional<StartPose> start;
  std::string reference;  ///< a trajectory file, for evaluation alone; may be empty
  /// The default drops what lies nearer than half a metre: the robot itself.
  std::vector<FilterStep> filters = {{"range", {{"min", 0.5}}}};
  std::optional<RobotGps> gps;
  std::optional<GravityPrior> gravity;  ///< in the frame of every scan
};

/// Tiles that a drone map is cut into because it is bent: one similarity each. The standard
/// deviations are those of two neighbours whose middles are kSection apart; their variances grow
/// with that distance. The defaults are those of ALGORITHMS 6.7.
struct MapTiling {
  static constexpr double kSection = 30.0;               ///< metres
  static constexpr double kLeastSize = 1.0;              ///< metres: less than a surface is no tile
  double size = 30.0;                                    ///< edge of a tile, metres
  double sigma_scale = 0.002;                            ///< relative
  double sigma_rotation = 0.1 * std::numbers::pi / 180;  ///< radians, per axis
  double sigma_translation = 0.03;                       ///< metres, per axis, at the common border
};

/// A drone map, as the site file names it.
struct DroneMapSite {
  std::string name, cloud, cameras, gps, image_times;
  std::optional<double> scale_sigma;         ///< relative; in place of what the positions tell
  std::optional<double> gps_sigma;           ///< metres, of one position and axis; likewise
  std::optional<double> scale = {};          ///< metres per unit, where no positions tell
  std::optional<GravityPrior> gravity = {};  ///< in the map's own frame
  std::string reference = {};  ///< JSON file with the true `scale`, for evaluation alone; or empty
  std::optional<double> true_scale = {};  ///< of that file, metres per unit
  std::optional<MapTiling> tiles = {};    ///< absent: the map is one similarity
};

/// A site file: what `planegraph map` works on. Paths are absolute or relative to the working
/// folder.
struct Site {
  std::string name;
  std::optional<GeodeticPosition> origin;  ///< of the world's east-north-up frame
  std::vector<RobotSite> robots;
  std::vector<DroneMapSite> maps;
};

/// Reads SITE.yaml. An unknown key, a missing file, a glob without a match, or odometry of another
/// length than the scans is an InputError that names the line.
Site ReadSite(const std::string& path);

}  // namespace planegraph
