#pragma once

#include <vector>

#include "planegraph/correspondence/scan_model.h"
#include "planegraph/geometry/rigid3.h"

namespace planegraph {

/// Scans whose relative poses are known, as one rigid body: a single scan, or several that together
/// say more of where they stand than each by itself. The models must outlive the group.
struct ScanGroup {
  std::vector<const ScanModel*> scans;
  std::vector<Rigid3> group_from_scan;

  ScanGroup() = default;
  /// One scan, the group's frame being its own.
  explicit ScanGroup(const ScanModel& scan) : scans{&scan}, group_from_scan{Rigid3()} {}
};

/// The scans of a group that stand within `radius` metres of one of them, in that scan's frame.
ScanGroup Around(const ScanGroup& group, std::size_t anchor, double radius);

/// Scans that stand for their surroundings in the group: the first one, then always the one that is
/// farthest from all before, while that is more than `distance` metres; at most `most`.
std::vector<std::size_t> Anchors(const ScanGroup& group, double distance, std::size_t most);

/// A surfel of the group with what it counts; the weights of each scan sum to one.
struct GroupSample {
  Eigen::Vector3d mean, normal;  ///< group frame, metres
  double weight;
  std::size_t scan;      ///< index in the group
  std::uint32_t surfel;  ///< index in that scan's surfels
};

/// The scans' samples, at most `most_per_scan` of each, evenly.
std::vector<GroupSample> SamplesOf(const ScanGroup& group, std::size_t most_per_scan);

/// The directions that the group's planes face, heaviest first, in the group's frame; `planes` of
/// the clusters stay empty.
std::vector<DirectionCluster> DirectionsOf(const ScanGroup& group);

}  // namespace planegraph
