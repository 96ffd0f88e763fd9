#include "planegraph/correspondence/surface_filter.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <numbers>

#include "planegraph/geometry/cube_side.h"

namespace planegraph {
namespace {

// A face marks some thirty bits. With so many for each face one in fifteen is set.
constexpr std::uint64_t kBitsPerFace = 512;
constexpr std::uint64_t kMostBits = std::uint64_t{1} << 27;  // 16 MB: large maps get fewer each
constexpr double kRounding = 1e-9;                           // metres

}  // namespace

SurfaceFilter::SurfaceFilter(const std::vector<SurfaceFace>& faces) {
  std::uint64_t bits = 1024;
  while (bits < std::min(kBitsPerFace * faces.size(), kMostBits)) bits *= 2, --shift_;
  bits_.assign(bits / 64, 0);
  for (const SurfaceFace& face : faces) Mark(face);
}

// A side is the cone between the four planes that halve the angles to its neighbours. A direction
// in it is off none of their inner halves, one near by at most by the sine.
std::uint32_t SurfaceFilter::SidesNear(const Eigen::Vector3d& normal) {
  static const double kLeast = -std::numbers::sqrt2 * std::sqrt(1.0 - kCosine * kCosine);
  std::uint32_t sides = 0;
  for (int side = 0; side < 6; ++side) {
    const int axis = side / 2;
    const double along = side % 2 == 0 ? normal[axis] : -normal[axis];
    const double across =
        std::max(std::abs(normal[(axis + 1) % 3]), std::abs(normal[(axis + 2) % 3]));
    if (along - across >= kLeast) sides |= 1u << side;
  }
  return sides;
}

void SurfaceFilter::MarkCell(std::uint64_t cell, std::uint32_t sides) {
  for (; sides != 0; sides &= sides - 1) {
    const std::uint64_t bit = Bit(cell, std::countr_zero(sides));
    bits_[bit / 64] |= std::uint64_t{1} << bit % 64;
  }
}

// All cells that the face overlaps, thickened by the gate: columns of cells along the axis that the
// normal is nearest to.
void SurfaceFilter::Mark(const SurfaceFace& face) {
  const Eigen::Vector3d &n = face.normal, slope = n.cwiseAbs();
  const std::uint32_t sides = SidesNear(n);
  const int w = CubeSide(n) / 2, u = (w + 1) % 3, v = (w + 2) % 3;
  const Eigen::Vector3d extent =
      (Eigen::Vector3d::Ones() - n.cwiseAbs2()).cwiseMax(0.0).cwiseSqrt() * face.reach +
      (kGate * slope).array().matrix() + Eigen::Vector3d::Constant(kRounding);
  const Eigen::Vector3d low = face.mean - extent, high = face.mean + extent;
  // Half of what the slab takes of a column: its own thickness, and its rise within a cell.
  const double half =
      (kGate + 0.5 * SurfaceCells::kEdge * (slope[u] + slope[v])) / slope[w] + kRounding;
  Eigen::Vector3i at;
  for (at[u] = SurfaceCells::Of(low[u]); at[u] <= SurfaceCells::Of(high[u]); ++at[u]) {
    for (at[v] = SurfaceCells::Of(low[v]); at[v] <= SurfaceCells::Of(high[v]); ++at[v]) {
      const double rise = n[u] * (SurfaceCells::Centre(at[u]) - face.mean[u]) +
                          n[v] * (SurfaceCells::Centre(at[v]) - face.mean[v]);
      const double height = face.mean[w] - rise / n[w];
      const int last = SurfaceCells::Of(std::min(height + half, high[w]));
      for (at[w] = SurfaceCells::Of(std::max(height - half, low[w])); at[w] <= last; ++at[w]) {
        MarkCell(SurfaceCells::Key(at.x(), at.y(), at.z()), sides);
      }
    }
  }
}

}  // namespace planegraph
