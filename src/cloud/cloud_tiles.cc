#include "planegraph/cloud/cloud_tiles.h"

#include <algorithm>
#include <cmath>
#include <map>

namespace planegraph {

TileKey TileOf(const Eigen::Vector3f& point, double edge) {
  return {std::lround(std::floor(point.x() / edge)), std::lround(std::floor(point.y() / edge))};
}

std::size_t CloudTiles::Points() const {
  std::size_t points = 0;
  for (std::size_t t = 0; t < count(); ++t) points += PointsOf(t);
  return points;
}

std::size_t CloudTiles::PointsOfLargest() const {
  std::size_t most = 0;
  for (std::size_t t = 0; t < count(); ++t) most = std::max(most, PointsOf(t));
  return most;
}

TilesInMemory::TilesInMemory(const Cloud& cloud, double edge) : cloud_(cloud) {
  std::map<TileKey, std::vector<std::uint32_t>> tiles;
  for (std::uint32_t i = 0; i < cloud.size(); ++i) {
    tiles[TileOf(cloud.points[i], edge)].push_back(i);
  }
  for (auto& [key, points] : tiles) tiles_.push_back(std::move(points));
}

}  // namespace planegraph
