#pragma once

#include <map>
#include <memory>
#include <utility>
#include <vector>

#include "planegraph/geometry/sim3.h"
#include "planegraph/pipeline/site.h"
#include "planegraph/segmentation/plane_segment.h"

namespace planegraph {

/// A drone map cut into square tiles, each a similarity of its own (ALGORITHMS 6.7): upright
/// columns over the world's x and y, laid out from the middle of the map's surfaces, those cells
/// alone that hold some. The frame of the map does not matter to them.
class MapGrid {
 public:
  /// Neighbouring tiles, and the middle of the border that they share.
  struct Tie {
    int target, source;
    Eigen::Vector3d border;  ///< metric frame
    double distance;         ///< of the tiles' middles, metres
  };
  /// Tiles and their weights, which add up to 1.
  using Blend = std::vector<std::pair<int, double>>;
  static constexpr std::size_t kMostTiles = 1000;

  /// Of the planes of a map in its metric frame. Throws InputError naming `file` where there would
  /// be more than kMostTiles.
  MapGrid(const MapTiling& tiling, const PlaneSet& planes, const Sim3& world_from_metric,
          const std::string& file);

  std::size_t count() const { return middles_.size(); }
  /// The tile whose cell a place (metric frame) is in, else the one whose middle is nearest.
  int TileAt(const Eigen::Vector3d& place) const;
  /// Bilinear between the middles of the cells about a place; a cell without surfaces is its
  /// nearest tile's. Continuous everywhere, and one tile's alone at its middle.
  Blend At(const Eigen::Vector3d& place) const;
  /// Middle of a tile's cell at the mean height of its surfaces, metric frame.
  const Eigen::Vector3d& Middle(int tile) const { return middles_[tile]; }
  /// Tiles that share a border, and the shortest ways across gaps, so that all hang together.
  const std::vector<Tie>& ties() const { return ties_; }
  const MapTiling& tiling() const { return tiling_; }

 private:
  using Cell = std::pair<int, int>;
  Eigen::Vector2d InCells(const Eigen::Vector3d& place) const;
  int TileOfCell(const Cell& cell) const;
  int Nearest(const Cell& cell) const;
  void FindTiles(const PlaneSet& planes, const std::string& file);
  void AddTie(int target, int source);
  void TieNeighbours();
  void TieAcrossGaps();

  MapTiling tiling_;
  Sim3 world_from_metric_;
  Eigen::Vector2d low_ = Eigen::Vector2d::Zero();
  std::map<Cell, int> tiles_;
  std::vector<Cell> cells_;  // of the tiles
  std::vector<Eigen::Vector3d> middles_;
  std::vector<Tie> ties_;
};

/// Standard deviation of where a similarity takes a place, in the worst direction, metres; NaN
/// where nothing holds it.
double SigmaOfPlace(const Matrix7d& covariance, const Sim3& world_from_metric,
                    const Eigen::Vector3d& place);

/// A map whose tiles have moved against each other; without a grid it is not cut.
struct BentMap {
  std::shared_ptr<const MapGrid> grid;
  std::vector<Sim3> world_from_tile;  ///< from the metric frame, which all tiles share

  /// Where a place of the metric frame comes to lie: the mean of what its tiles say, blended.
  Eigen::Vector3d operator*(const Eigen::Vector3d& place) const;
};

/// The similarity that is nearest to a bent map over its surfaces, and what it leaves.
struct BendingFit {
  Sim3 world_from_metric;
  double rms = 0.0, largest = 0.0;  ///< metres: of a patch of the map from where its tiles have it
};
BendingFit FitBentMap(const BentMap& map, const PlaneSet& planes);

/// How the fit moves with each tile, by their perturbations (decoupled left, in the world's axes).
std::vector<Matrix7d> FitByTiles(const BentMap& map, const BendingFit& fit, const PlaneSet& planes);

}  // namespace planegraph
