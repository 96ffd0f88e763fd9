#pragma once

#include <cstddef>
#include <vector>

#include "planegraph/geometry/rigid3.h"
#include "planegraph/segmentation/plane_segment.h"

namespace planegraph {

struct MetascanOptions {
  int least_overlaps = 3;         ///< overlapping surfaces that make two scans neighbours
  double min_translation = 0.01;  ///< metres: a smaller change of a pose is none
  double min_rotation_deg = 0.1;
  int most_pops_per_scan = 20;  ///< the queue need not run empty; this bounds it
  /// Surfaces coincide when they face alike, lie in one plane and overlap. The gates are wide for a
  /// scan that is new, and narrow within the metascan.
  double max_angle_deg = 4.0, group_angle_deg = 2.0;
  double max_offset = 0.4, group_offset = 0.05;  ///< metres along the normal
  double overlap_tolerance = 0.0;                ///< metres, of the boxes in the plane
  double min_area = 2.0;                         ///< m^2: smaller segments take no part
  int max_iterations = 5;  ///< of association and closed form in one registration
  /// Scans that a drone map has placed (empty: none): they keep their start and move never. The
  /// paper optimizes only the others so.
  std::vector<bool> fixed;
};

struct MetascanResult {
  std::vector<Rigid3> poses;  ///< world_from_scan
  std::size_t pops = 0;       ///< scans taken off the queue
  bool terminated = true;     ///< the queue ran empty each time
  /// Scans that found no neighbour with enough overlapping surfaces and stayed where they were.
  std::vector<std::size_t> alone;
};

/// Simultaneous matching (Surmann et al. 2003, for surfaces as in the paper): scans join in order,
/// the first one is the master and stays. A new scan starts the queue; each scan taken off it is
/// registered, by planes in closed form, to the metascan of its neighbours, in which coinciding
/// segments are one with merged moments and areas; where its pose changed, its neighbours join the
/// queue. Poses are world_from_scan, `start` as it is known so far; a new scan keeps its relation
/// to the scan before it. Hard correspondences, no uncertainty: the baseline of the graph.
/// Directions that the planes leave open stay as they were. Throws UsageError for unequal counts.
MetascanResult OptimizeMetascan(const std::vector<PlaneSet>& scans,
                                const std::vector<Rigid3>& start,
                                const MetascanOptions& options = {});

}  // namespace planegraph
