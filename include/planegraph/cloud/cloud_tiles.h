#pragma once

#include <cstdint>
#include <utility>
#include <vector>

#include "planegraph/cloud/cloud.h"

namespace planegraph {

/// The square of the horizontal plane that a point is in, counted from zero.
using TileKey = std::pair<long, long>;
TileKey TileOf(const Eigen::Vector3f& point, double edge);

/// A cloud by square tiles of the horizontal plane, wherever its points are. The tiles that hold
/// points are in the order of their keys, the points of a tile in that of the cloud; every point is
/// in one tile.
class CloudTiles {
 public:
  virtual ~CloudTiles() = default;
  virtual std::size_t count() const = 0;  ///< of tiles
  virtual std::size_t PointsOf(std::size_t tile) const = 0;
  /// The points of a tile, for several threads at a time.
  virtual Cloud Load(std::size_t tile) const = 0;

  std::size_t Points() const;  ///< of all tiles
  std::size_t PointsOfLargest() const;
};

/// The tiles of a cloud in memory, which must outlive this.
class TilesInMemory : public CloudTiles {
 public:
  TilesInMemory(const Cloud& cloud, double edge);

  std::size_t count() const override { return tiles_.size(); }
  std::size_t PointsOf(std::size_t tile) const override { return tiles_[tile].size(); }
  Cloud Load(std::size_t tile) const override { return Select(cloud_, tiles_[tile]); }
  /// Indices into the cloud.
  const std::vector<std::uint32_t>& IndicesOf(std::size_t tile) const { return tiles_[tile]; }

 private:
  const Cloud& cloud_;
  std::vector<std::vector<std::uint32_t>> tiles_;
};

}  // namespace planegraph
