#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <unordered_set>
#include <vector>

#include "planegraph/cloud/cloud.h"

namespace planegraph {

/// One point of each voxel of a cloud that comes tile by tile: what the tiles' own thinning leaves,
/// but of the voxels that a border cuts one of their points alone. Remembers these voxels.
class TiledThinning {
 public:
  /// `voxel`: edge of the voxels, 0 or less: all points stay; `tile`: of the tiles, both metres.
  TiledThinning(double voxel, double tile) : voxel_(voxel), tile_(tile) {}

  /// Those of a tile's points, one in each voxel, whose voxel no tile before had.
  std::vector<std::uint32_t> Keep(const Cloud& cloud, std::vector<std::uint32_t> points);

 private:
  bool IsCut(double cell) const;

  double voxel_, tile_;
  std::unordered_set<std::uint64_t> cut_;
};

}  // namespace planegraph
