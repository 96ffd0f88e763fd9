#pragma once

#include <Eigen/Core>
#include <cstdint>

namespace planegraph {

/// Voxels from the origin along an axis that a key has room for: 21 bits for both directions.
inline constexpr double kMostVoxels = 1 << 20;
/// No voxel's key: those have 63 bits.
inline constexpr std::uint64_t kNoVoxel = ~0ull;

/// One number for the voxel of edge `voxel` that the point is in, both in the same unit; kNoVoxel
/// where it lies farther out than keys reach, or is not finite.
inline std::uint64_t VoxelKey(const Eigen::Vector3d& point, double voxel) {
  const Eigen::Array3d cell = (point / voxel).array().floor();
  if (!(cell.abs() < kMostVoxels).all()) return kNoVoxel;
  std::uint64_t key = 0;
  for (int axis = 0; axis < 3; ++axis) {
    key = (key << 21) | static_cast<std::uint64_t>(cell[axis] + kMostVoxels);
  }
  return key;
}

}  // namespace planegraph
