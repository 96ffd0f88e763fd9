#include "segmentation/support_mask.h"

#include <algorithm>
#include <cmath>

namespace planegraph {
namespace {

using Cells = std::vector<std::uint8_t>;

// One pass of a 3x3 minimum or maximum; the border counts as empty.
Cells Morph(const Cells& cells, int width, int height, bool dilate) {
  Cells out(cells.size());
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      bool any = false, all = true;
      for (int dy = -1; dy <= 1; ++dy) {
        for (int dx = -1; dx <= 1; ++dx) {
          const int xx = x + dx, yy = y + dy;
          const bool inside = xx >= 0 && yy >= 0 && xx < width && yy < height;
          const bool set = inside && cells[std::size_t(yy) * width + xx];
          any |= set, all &= set;
        }
      }
      out[std::size_t(y) * width + x] = dilate ? any : all;
    }
  }
  return out;
}

// Twice the signed area of the triangle o, a, b.
double Cross(const Eigen::Vector2d& o, const Eigen::Vector2d& a, const Eigen::Vector2d& b) {
  return (a - o).x() * (b - o).y() - (a - o).y() * (b - o).x();
}

}  // namespace

SupportMask BuildSupportMask(const Eigen::Vector3d& origin, const Eigen::Vector3d& u,
                             const Eigen::Vector3d& v, double cell_size,
                             const std::vector<Eigen::Vector2d>& projected) {
  SupportMask mask{origin, u, v, cell_size, 0, 0, 0, 0, {}};
  if (projected.empty()) return mask;
  Eigen::Vector2d low = projected.front(), high = projected.front();
  for (const auto& p : projected) low = low.cwiseMin(p), high = high.cwiseMax(p);
  // A margin of two cells: one for the dilation, one so that the erosion sees its border.
  mask.min_i = static_cast<int>(std::floor(low.x() / cell_size)) - 2;
  mask.min_j = static_cast<int>(std::floor(low.y() / cell_size)) - 2;
  mask.width = static_cast<int>(std::floor(high.x() / cell_size)) + 3 - mask.min_i;
  mask.height = static_cast<int>(std::floor(high.y() / cell_size)) + 3 - mask.min_j;
  mask.cells.assign(std::size_t(mask.width) * mask.height, 0);
  for (const auto& p : projected) {
    const int x = static_cast<int>(std::floor(p.x() / cell_size)) - mask.min_i;
    const int y = static_cast<int>(std::floor(p.y() / cell_size)) - mask.min_j;
    mask.cells[std::size_t(y) * mask.width + x] = 1;
  }
  mask.cells = Morph(mask.cells, mask.width, mask.height, true);
  mask.cells = Morph(mask.cells, mask.width, mask.height, false);
  return mask;
}

double MaskArea(const SupportMask& mask) {
  return mask.cell_size * mask.cell_size *
         static_cast<double>(std::count(mask.cells.begin(), mask.cells.end(), 1));
}

std::vector<Eigen::Vector2d> ConvexHull(std::vector<Eigen::Vector2d> points) {
  std::sort(points.begin(), points.end(), [](const auto& a, const auto& b) {
    return a.x() != b.x() ? a.x() < b.x() : a.y() < b.y();
  });
  if (points.size() < 3) return points;
  std::vector<Eigen::Vector2d> hull;
  const auto chain = [&hull](auto begin, auto end) {
    const std::size_t base = hull.size();
    for (auto it = begin; it != end; ++it) {
      while (hull.size() >= base + 2 && Cross(hull[hull.size() - 2], hull.back(), *it) <= 0) {
        hull.pop_back();
      }
      hull.push_back(*it);
    }
    hull.pop_back();  // the last point starts the other chain
  };
  chain(points.begin(), points.end());
  chain(points.rbegin(), points.rend());
  return hull;
}

}  // namespace planegraph
