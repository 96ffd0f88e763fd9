#pragma once

#include <map>
#include <string>
#include <utility>
#include <vector>

#include "planegraph/cloud/cloud.h"

namespace planegraph {

/// What stands for the points of a voxel.
enum class VoxelPoint { kFirst, kCentroid };

/// One point per cubic voxel of edge `size` (metres, aligned with the cloud's offset), in the order
/// of the voxels' first points. Keys have 64 bits (21 per axis, about two million voxels each way).
/// With kCentroid positions and attributes are means, normals renormalized. Throws UsageError where
/// the size is not positive or the cloud spans too many voxels.
Cloud VoxelFilter(const Cloud& cloud, double size, VoxelPoint point = VoxelPoint::kCentroid);

/// Drops points whose mean distance to their k nearest neighbours exceeds the mean over the cloud
/// by more than `stddev` standard deviations (Rusu et al. 2008).
Cloud OutlierFilter(const Cloud& cloud, std::size_t k = 50, double stddev = 1.0, int threads = 1);

/// Keeps points with min <= distance to the viewpoint <= max, metres.
Cloud RangeFilter(const Cloud& cloud, double min, double max);

/// Drops points that the beam meets at more than `max_deg` from the normal. Throws UsageError where
/// the cloud has no normals. Points with a zero normal stay.
Cloud IncidenceFilter(const Cloud& cloud, double max_deg);

/// A step of a chain: a filter's name with the parameters that differ from their defaults.
struct FilterStep {
  std::string name;
  std::map<std::string, double> parameters;
};

/// What a filter is called and takes, for documentation.
struct FilterDescription {
  std::string name, help;
  std::map<std::string, double> defaults;
};
/// voxel (size, centroid: 1 or 0), outlier (k, stddev), range (min, max), incidence (max_deg),
/// normals (k).
const std::vector<FilterDescription>& ListFilters();

/// Filters in the order given. Throws UsageError at once for an unknown filter, an unknown
/// parameter or a value out of range.
class FilterChain {
 public:
  FilterChain() = default;
  explicit FilterChain(std::vector<FilterStep> steps);

  bool empty() const { return steps_.empty(); }
  Cloud Apply(Cloud cloud, int threads = 1) const;

 private:
  std::vector<FilterStep> steps_;  // with every parameter set
};

}  // namespace planegraph
