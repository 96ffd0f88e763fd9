#include "pipeline/tiled_thinning.h"

#include <algorithm>
#include <cmath>

#include "planegraph/cloud/voxel_key.h"

namespace planegraph {

// With a hair's breadth to spare: points may be rounded to either side.
bool TiledThinning::IsCut(double cell) const {
  constexpr double kSpare = 1e-3;  // of a voxel
  const double low = (cell - kSpare) * voxel_, high = (cell + 1.0 + kSpare) * voxel_;
  return std::floor(low / tile_) != std::floor(high / tile_);
}

std::vector<std::uint32_t> TiledThinning::Keep(const Cloud& cloud,
                                               std::vector<std::uint32_t> points) {
  if (!(voxel_ > 0.0)) return points;
  std::erase_if(points, [&](std::uint32_t i) {
    const Eigen::Vector3d point = cloud.Position(i);
    if (!IsCut(std::floor(point.x() / voxel_)) && !IsCut(std::floor(point.y() / voxel_))) {
      return false;
    }
    return !cut_.insert(VoxelKey(point, voxel_)).second;
  });
  return points;
}

}  // namespace planegraph
