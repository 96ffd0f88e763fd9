#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "planegraph/correspondence/surface_cells.h"

namespace planegraph {

/// A piece of a surface as it answers for places near it, in one line of the cache: up to `reach`
/// metres from its mean, within its plane.
struct alignas(64) SurfaceFace {
  Eigen::Vector3d normal, mean;  ///< unit; metres
  double reach;
};

/// Tells at the cost of one bit where no face can be: most places that a wrong pose leads to are
/// empty. The bits stand for hashed cells and for the side that is asked for, so that some say yes
/// for nothing, but none says no where a face answers.
class SurfaceFilter {
 public:
  /// What is asked for: faces within kGate metres along their normal, facing like the direction up
  /// to this cosine (21.5 degrees).
  static constexpr double kGate = 0.5, kCosine = 0.93;
  static constexpr std::uint32_t kAllSides = 63;

  SurfaceFilter() : bits_(16, 0) {}
  explicit SurfaceFilter(const std::vector<SurfaceFace>& faces);

  /// The sides (CubeSide) of all directions within the angle of kCosine, as bits.
  static std::uint32_t SidesNear(const Eigen::Vector3d& normal);

  /// Whether a face may lie at a point that faces like a direction of that side.
  bool MayLie(const Eigen::Vector3d& point, int side) const {
    const std::uint64_t bit = Bit(SurfaceCells::KeyOf(point), side);
    return (bits_[bit / 64] >> bit % 64 & 1) != 0;
  }

 private:
  std::uint64_t Bit(std::uint64_t cell, int side) const {
    return (8 * cell + static_cast<std::uint64_t>(side)) * 0x9e3779b97f4a7c15ull >> shift_;
  }
  void Mark(const SurfaceFace& face);
  void MarkCell(std::uint64_t cell, std::uint32_t sides);

  std::vector<std::uint64_t> bits_;
  int shift_ = 54;  // leaves as many bits of a hash as there are: 2^10
};

}  // namespace planegraph
