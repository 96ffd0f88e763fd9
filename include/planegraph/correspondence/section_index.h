#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <map>
#include <utility>
#include <vector>

#include "planegraph/correspondence/patch_map.h"

namespace planegraph {

/// Surfels by square columns of the map's x and y: which of them are about a place.
class SectionIndex {
 public:
  explicit SectionIndex(const std::vector<Surfel>& surfels);

  /// Indices of the surfels in all columns that a ball touches, in increasing order: all of those
  /// in the ball, and some beside it.
  std::vector<std::uint32_t> Near(const Eigen::Vector3d& centre, double radius) const;

 private:
  std::map<std::pair<long, long>, std::vector<std::uint32_t>> columns_;
};

}  // namespace planegraph
