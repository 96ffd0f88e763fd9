#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "planegraph/cloud/cloud.h"
#include "planegraph/segmentation/noise_model.h"
#include "planegraph/segmentation/plane_segment.h"

namespace planegraph {

/// What may be set by hand; the defaults fit laser scans from rooms to sites, since every threshold
/// on the points themselves follows from the noise model.
struct SegmentationOptions {
  CloudKind kind = CloudKind::kLaser;
  /// The sensor's noise; estimated from the cloud where absent.
  std::optional<NoiseModel> noise;
  double cell_size = 0.1;  ///< edge of the finest octree cell, metres
  int levels = 5;          ///< levels of the octree: the coarsest cell is cell_size * 2^(levels-1)
  int min_points = 50;     ///< least points of a segment
  double min_area = 0.05;  ///< least area of a segment, m^2
  double max_tilt_deg = 5.0;     ///< largest standard deviation of a planar cell's normal
  double planarity = 1.5;        ///< a plane's rms may exceed the expected noise by this factor
  double mask_cell_size = 0.25;  ///< of the support masks, metres; equal for clouds to be matched
  double correlation_length = 0.1;      ///< of the noise along a surface, metres (for N_eff)
  double floor_offset = 0.005;          ///< systematic error of a plane's offset, metres
  double floor_tilt_deg = 0.1;          ///< systematic error of a plane's normal
  bool greedy_projection_area = false;  ///< area by Marton 2009, as the paper has it (needs PCL)
};

/// The planes of a cloud and, for every point of it in order, the index of its segment in
/// planes.planes (-1: none).
struct Segmentation {
  PlaneSet planes;
  NoiseModel noise;
  std::vector<std::int32_t> labels;
};

/// Finds the planes of an unorganized cloud: an octree over hashed voxels whose cells are split
/// until they are planar, region growing over neighbouring cells with O(1) merges of their moments,
/// coplanar merge, and a point-wise refinement at the boundaries. Time O(N) but for the sort.
/// Sources: Xiao et al. 2013 (growing), Poppinga et al. 2008 (incremental moments), Liu et al. 2022
/// (BALM2, adaptive voxels).
Segmentation SegmentPlanes(const Cloud& cloud, const SegmentationOptions& options = {});

}  // namespace planegraph
