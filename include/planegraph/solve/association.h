#pragma once

#include <functional>
#include <vector>

#include "planegraph/graph/graph.h"
#include "planegraph/segmentation/plane_segment.h"

namespace planegraph {

struct AssociationOptions {
  double radius = 0.8;               ///< metres: how far a landmark's surfaces lie from its seed
  double gate = 0.15;                ///< metres along the normal
  double least_cosine = 0.97;        ///< between normals that are one
  double floor_offset = 0.002;       ///< systematic error of an observation's height, metres
  double floor_tilt = 0.0005;        ///< of its normal, radians
  double correlation_length = 0.05;  ///< metres: nearer points do not count as independent
  /// The same for the patches of drone maps, which are noisier: gate and cosine are the wider of
  /// both.
  double map_gate = 0.1, map_least_cosine = 0.94;
  double map_floor_offset = 0.01, map_floor_tilt = 0.005;
  double map_correlation_length = 0.5;
};

/// A drone map (or a tile of one) with where it is; its frame is metric up to a small correction.
struct PlacedMap {
  const PlaneSet* planes = nullptr;
  Sim3 world_from_map;
  /// Of a bent map: what takes a place of it to the world. Empty: world_from_map everywhere.
  std::function<const Sim3&(const Eigen::Vector3d& place)> world_from_place = {};
};

/// Landmarks from the planar patches of all scans under the given poses: patches of at least two
/// scans that lie in one plane within a small neighbourhood. Every patch is in at most one
/// landmark, and the patches of one scan in a landmark merge to one observation, so nothing is
/// counted twice. Walls and floors become many small landmarks: none has to be flat over its whole
/// length. The landmarks do not depend on the order of the scans but through ties of equal seeds.
///
/// A drone map counts as one more scan; its observations name it (PlaneObservation::map). Patches
/// of maps alone make no landmark.
std::vector<PlaneLandmark> AssociatePatches(const std::vector<const PlaneSet*>& scans,
                                            const std::vector<Rigid3>& world_from_scan,
                                            const AssociationOptions& options = {},
                                            const std::vector<PlacedMap>& maps = {});

}  // namespace planegraph
