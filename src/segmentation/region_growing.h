#pragma once

#include <cstdint>
#include <vector>

#include "segmentation/planar_cells.h"

namespace planegraph {

/// Planar cells of one plane, their sums, and the noise that is to be expected of them.
struct Region {
  std::vector<std::uint32_t> cells;  ///< indices into CellSplit::planar
  CellSums sums;
  double variance_sum = 0.0;  ///< sum over the points of sigma^2

  void Add(std::uint32_t cell, const CellSums& cell_sums, double sigma);
  void Add(const Region& other);
  double ExpectedVariance() const { return variance_sum / sums.count; }
};

/// Neighbours of every planar cell: planar cells that touch it, coarser or finer ones included.
std::vector<std::vector<std::uint32_t>> FindNeighbours(const CellOctree& octree,
                                                       const CellSplit& split);

/// Grows regions from the best determined cells; every planar cell is in exactly one region.
/// Regions of one plane that touch are merged.
std::vector<Region> GrowRegions(const CellOctree& octree, const CellSplit& split,
                                const std::vector<std::vector<std::uint32_t>>& neighbours,
                                double planarity);

}  // namespace planegraph
