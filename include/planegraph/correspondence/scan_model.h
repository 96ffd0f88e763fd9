#pragma once

#include <cstdint>
#include <vector>

#include "planegraph/correspondence/patch_map.h"
#include "planegraph/segmentation/plane_segment.h"

namespace planegraph {

/// Segments of a scan that face one way, gathered for hypotheses on rotation.
struct DirectionCluster {
  Eigen::Vector3d direction;         ///< unit, area-weighted mean normal
  double weight = 0.0;               ///< square root of the area, m: a ground is not everything
  std::vector<std::int32_t> planes;  ///< indices into PlaneSet::planes, largest first
};

/// One scan made ready for matching; built once, used for every pair. It refers to the plane set,
/// which must outlive it.
struct ScanModel {
  explicit ScanModel(const PlaneSet& plane_set);

  const PlaneSet* planes;
  PatchMap map;
  std::vector<DirectionCluster> directions;  ///< heaviest first
  /// Surfels to verify a hypothesis with, spread over the scan, and what each counts: surfaces of
  /// all directions count alike, however large the ground is. The weights sum to one.
  std::vector<std::uint32_t> samples;
  std::vector<double> sample_weights;
};

}  // namespace planegraph
