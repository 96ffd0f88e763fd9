#pragma once

#include <string>
#include <vector>

#include "planegraph/pipeline/front_end.h"
#include "planegraph/pipeline/map_front_end.h"
#include "planegraph/pipeline/site.h"

namespace planegraph {

/// Where a robot's antenna was when it scanned, by its receiver.
struct RobotPosition {
  std::size_t scan = 0;
  Eigen::Vector3d antenna = Eigen::Vector3d::Zero();   ///< scan's frame, metres
  Eigen::Vector3d position = Eigen::Vector3d::Zero();  ///< world, metres
  double sigma = 1.5;                                  ///< metres, of one position and axis
  /// Variance over that of independent errors: receivers err alike for a minute and more.
  double inflation = 1.0;
};

/// The positions of all robots that have a receiver, for the scans that its fixes enclose (at most
/// 5 s apart, or 1 s away; clocks may be whole days apart). They are in the world where a drone map
/// has GPS, or metric positions, that place it; else the world is the first scan's frame, nobody
/// knows how it lies on the earth, and the positions are left out with a warning. Throws
/// InputError.
std::vector<RobotPosition> ReadRobotPositions(const Site& site,
                                              const std::vector<ScanRecord>& scans,
                                              const std::vector<MapRecord>& maps,
                                              std::vector<std::string>* warnings);

}  // namespace planegraph
