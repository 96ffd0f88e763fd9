#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "planegraph/geometry/rigid3.h"
#include "planegraph/segmentation/plane_segment.h"

namespace planegraph {

/// Thresholds of the search of Xiao et al. 2013 with the overlap test of Surmann et al. The
/// defaults suit sites of some tens of metres; Room() suits rooms.
struct XiaoOptions {
  double min_area = 2.0;             ///< m^2: smaller segments take no part
  double max_area_difference = 0.5;  ///< of a pair, as a share of the larger area
  double least_angle_deg = 30.0;     ///< between two planes that fix a rotation, and 180 less it
  double max_angle_difference_deg = 3.0;
  double max_side_tilt_deg = 25.0;      ///< of the source's z axis: a ground robot's prior
  double max_translation = 50.0;        ///< metres
  double max_offset_difference = 0.06;  ///< metres along the normal, of a pair to be added
  double overlap_tolerance = 0.5;       ///< metres, the epsilon of the overlap test
  std::size_t most_triplets = 200000;   ///< that are grown to a consensus
  std::size_t least_candidates = 10;    ///< solutions that are re-estimated and grown again
  /// A re-estimation that changes R or t by more than this (sum of absolute differences; metres for
  /// t) refuses the solution. Published: 0.1 for both.
  double max_rotation_change = 0.1;
  double max_translation_change = 0.5;

  /// The values published for rooms (crashed car park, T-boxes).
  static XiaoOptions Room();
};

/// A plane of the target and a plane of the source that are taken to be one.
struct XiaoPair {
  std::int32_t target, source;  ///< indices into PlaneSet::planes
};

/// A pose with the pairs that agree with it.
struct XiaoSolution {
  Rigid3 target_from_source;
  std::vector<XiaoPair> pairs;
  double area_product = 0.0;  ///< sum of A_target * A_source, m^4
};

struct XiaoMatch {
  /// Best first, by count and then by the sum of area products; empty: nothing matched.
  std::vector<XiaoSolution> solutions;
  std::size_t area_pairs = 0;  ///< area-consistent pairs of segments
  std::size_t triplets = 0;    ///< grown to a consensus
  /// No three planes in general position agreed: the solutions come from two directions, and their
  /// translation along the intersection line of both is zero.
  bool two_directions_only = false;
  bool capped = false;  ///< the search stopped at most_triplets
  std::string reason;   ///< why there is no solution, or what limits it
  /// How many combinations were dropped, by reason.
  std::vector<std::pair<std::string, std::size_t>> rejected;
};

/// The correspondence search of Xiao et al. 2013 (after the description of its published
/// implementation, without that one's defects): pairs of similar area, pairs of pairs with equal
/// angles, a third pair that fixes the translation, growing of the consensus, and choice by count
/// and area. Overlap as in Surmann et al.: boxes in the basis of the target plane, its normal left
/// out.
XiaoMatch MatchXiao(const PlaneSet& target, const PlaneSet& source,
                    const XiaoOptions& options = {});

/// A segment's rectangle about its support, in its own plane.
struct PlaneBox {
  Eigen::Vector3d center, u, v;
  double half_u = 0.0, half_v = 0.0;  ///< metres
};
PlaneBox MakePlaneBox(const PlaneSegment& segment);

/// The overlap test of Surmann et al.: the source's box, moved by the transform, and the target's
/// overlap along both in-plane axes of the target, up to the tolerance in metres.
bool BoxesOverlap(const PlaneBox& target, const PlaneBox& source, const Eigen::Matrix3d& rotation,
                  const Eigen::Vector3d& translation, double tolerance);

}  // namespace planegraph
