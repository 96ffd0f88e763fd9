#pragma once

#include <Eigen/Core>
#include <cstdint>

namespace planegraph {

/// The grid of cubes by which surfaces are found again, and its cells as numbers for a hash.
struct SurfaceCells {
  static constexpr double kEdge = 0.8;   ///< metres
  static constexpr int kBias = 1 << 20;  ///< makes every cell's coordinates positive

  // With the bias truncation is rounding down, at a fraction of floor's cost.
  static int Of(double coordinate) {
    constexpr double kPerMetre = 1.0 / kEdge;
    return static_cast<int>(coordinate * kPerMetre + kBias);
  }
  static double Centre(int cell) { return (static_cast<double>(cell) - kBias + 0.5) * kEdge; }
  static std::uint64_t Key(int x, int y, int z) {
    return (static_cast<std::uint64_t>(x) << 42) | (static_cast<std::uint64_t>(y) << 21) |
           static_cast<std::uint64_t>(z);
  }
  static std::uint64_t KeyOf(const Eigen::Vector3d& point) {
    return Key(Of(point.x()), Of(point.y()), Of(point.z()));
  }
};

}  // namespace planegraph
