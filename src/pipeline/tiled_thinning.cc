#include "pipeline/tiled_thinning.h"

#include <algorithm>
#include <cmath>

namespace planegraph {

// With a hair's breadth to spare: points may be rounded to either side.
bool TiledThinning::IsCut(double cell) const {
  constexpr double kSpare = 1e-3;  // of a voxel
  const double low = (cell - kSpare) * voxel_, high = (cell + 1.0 + kSpare) * voxel_;
  return std::floor(low / tile_) != std::floor(high / tile_);
}

std::vector<std::uint32_t> TiledThinning::Keep(const Cloud& cloud,
                                               std::vector<std::uint32_t> points) {
  constexpr double kMost = 1 << 20;  // cells from zero: FirstOfEachVoxel takes no more
  if (!(voxel_ > 0.0)) return points;
  std::erase_if(points, [&](std::uint32_t i) {
    const Eigen::Array3d cell = (cloud.Position(i) / voxel_).array().floor();
    if (!IsCut(cell.x()) && !IsCut(cell.y())) return false;
    std::uint64_t key = 0;
    for (int axis = 0; axis < 3; ++axis) {
      key = (key << 21) | static_cast<std::uint64_t>(cell[axis] + kMost);
    }
    return !cut_.insert(key).second;
  });
  return points;
}

}  // namespace planegraph
