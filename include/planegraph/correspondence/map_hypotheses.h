#pragma once

#include <optional>
#include <vector>

#include "planegraph/correspondence/map_model.h"
#include "planegraph/correspondence/scan_group.h"
#include "planegraph/geometry/sim3.h"

namespace planegraph {

/// What is known of a group's place in a map before anything is matched. p_map = scale * R *
/// p_group
/// + t, in the map's frame, whose unit is a metre but for `sigma_scale`.
struct MapPrior {
  struct Pose {
    Rigid3 map_from_group;
    double sigma_translation;  ///< metres, each axis
    double sigma_rotation;     ///< radians, each axis
  };
  std::optional<Pose> pose;   ///< absent: anywhere in the map
  double scale = 1.0;         ///< of the map's frame: units per metre, as far as it is known
  double sigma_scale = 0.02;  ///< standard deviation of log(scale), mean 0
  /// The map's z axis points up, and the scanners stand about upright.
  bool upright = false;
  double most_tilt = 0.5;  ///< radians, of an upright scanner
};

struct MapHypothesis {
  Sim3 map_from_group;
  int votes = 0;  ///< of at most kMapVoters surfaces of the group
};
inline constexpr std::size_t kMapVoters = 192;

/// Poses of the group in the map by vote: rotations from pairs of plane directions at equal angles
/// (and, where the vertical is known, a sweep of the heading); for each of them, and for scales
/// within three standard deviations, every surface of the group votes for all translations that put
/// it on a surface of the map that faces the same way. The table of all translations is counted at
/// once (no cells, no sampling). Most votes first.
std::vector<MapHypothesis> FindMapHypotheses(const MapModel& map, const ScanGroup& group,
                                             const MapPrior& prior, std::size_t most,
                                             int threads = 1);

}  // namespace planegraph
