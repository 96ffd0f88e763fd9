#pragma once

#include <string>
#include <vector>

#include "planegraph/pipeline/site.h"
#include "planegraph/segmentation/segmenter.h"

namespace planegraph {

/// One scan after the front end: its planes, not its points.
struct ScanRecord {
  std::string id;  ///< ROBOT/NNN
  std::string file;
  std::size_t robot = 0, index = 0;
  double time = 0.0;  ///< of the odometry line; without odometry the index
  PlaneSet planes;
  std::vector<std::int32_t> labels;  ///< per filtered point the plane's index, -1: none
  std::size_t points = 0, points_filtered = 0;
  double reach = 0.0;           ///< metres: how far its farthest point lies from the scanner
  bool units_doubtful = false;  ///< the points are so far away that their unit may not be metres
  double seconds_read = 0, seconds_preprocess = 0, seconds_segment = 0;
};

/// Whether a scan is the first of its robot's way; `scans` hold robot after robot, each in the
/// order of its time stamps.
inline bool IsFirstOfRobot(const std::vector<ScanRecord>& scans, std::size_t i) {
  return i == 0 || scans[i - 1].robot != scans[i].robot;
}

/// Indices of a robot's scans in the order of their time stamps, where its odometry has some: the
/// order of their files then has no influence on the result. Else the files' order is the way's.
std::vector<std::size_t> OrderAlongWay(const RobotSite& robot);

/// A scan's points as every later step sees them: read and filtered, the same each time.
struct LoadedScan {
  Cloud cloud;
  std::size_t points = 0;  ///< before the filters
  double seconds_read = 0, seconds_preprocess = 0;
};
LoadedScan LoadScan(const RobotSite& robot, std::size_t index);

/// Reads, filters and segments one scan (steps k and l of the paper). Throws InputError.
ScanRecord PrepareScan(const Site& site, std::size_t robot, std::size_t index,
                       const SegmentationOptions& options);

}  // namespace planegraph
