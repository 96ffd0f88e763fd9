#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <vector>

#include "planegraph/cloud/cloud.h"
#include "planegraph/geometry/moments.h"

namespace planegraph {

/// Count, sum and sum of products of points: cells of an octree merge by mere addition. The points
/// are taken relative to the cloud's offset, where a scan's coordinates are small enough for that.
struct CellSums {
  double count = 0.0;
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  double xx = 0, xy = 0, xz = 0, yy = 0, yz = 0, zz = 0;

  void Add(const Eigen::Vector3f& point);
  void Add(const CellSums& other);
  Moments ToMoments() const;
};

/// An octree of hashed voxels over a cloud, built by sorting the points along the Morton curve.
/// Level 0 holds the finest cells (edge `cell_size`), level l cells of edge cell_size * 2^l. The
/// cells of a level are in Morton order, so the points and the children of a cell are contiguous.
class CellOctree {
 public:
  struct Cell {
    std::uint64_t key;  ///< Morton code of the cell at its level
    std::uint32_t first_point, point_count;
    std::uint32_t first_child, child_count;  ///< in the level below
  };

  /// Throws std::length_error where the extent is more than 2^21 cells along an axis.
  CellOctree(const Cloud& cloud, double cell_size, int levels);

  int levels() const { return static_cast<int>(levels_.size()); }
  double CellSize(int level) const { return cell_size_ * static_cast<double>(1 << level); }
  const std::vector<Cell>& Level(int level) const { return levels_[level]; }
  /// Sums over the points of a cell.
  CellSums Sums(int level, std::uint32_t index) const {
    return level == 0 ? FinestSums(levels_[0][index]) : sums_[level][index];
  }
  /// Index of the point at position i of the Morton order.
  const std::vector<std::uint32_t>& order() const { return order_; }
  /// The points in Morton order.
  const std::vector<Eigen::Vector3f>& sorted_points() const { return sorted_points_; }
  /// Index of the cell at the integer coordinates (at that level), -1 where it is empty.
  int Find(int level, const Eigen::Vector3i& coordinates) const;
  /// Likewise by the cell's Morton code at that level.
  int Find(int level, std::uint64_t key) const;
  /// Integer coordinates of a cell at its level.
  static Eigen::Vector3i Coordinates(std::uint64_t key);

 private:
  // Most look-ups are for empty cells: the tag tells them apart without a look at the cell.
  struct Slot {
    std::uint32_t cell, tag;
  };
  struct HashTable {
    std::vector<Slot> slots;
    std::uint64_t mask = 0;
  };

  std::vector<std::uint64_t> SortPoints(const Cloud& cloud);
  void BuildFinest(const std::vector<std::uint64_t>& keys);
  void BuildNext();
  CellSums FinestSums(const Cell& cell) const;
  void BuildTable(int level);

  double cell_size_;
  std::vector<std::uint32_t> order_;
  std::vector<Eigen::Vector3f> sorted_points_;
  std::vector<std::vector<Cell>> levels_;
  // Not of the finest level: its cells hold one or two points each, and are most of the cells by
  // far.
  std::vector<std::vector<CellSums>> sums_;
  std::vector<HashTable> tables_;
};

/// The Morton codes of a cell and of the 26 about it, without taking its coordinates apart. Not for
/// cells at the border of the code's range; the octree's grid keeps off it.
class NeighbourKeys {
 public:
  explicit NeighbourKeys(std::uint64_t key);
  /// k in 0..26: x fastest, then y and z, each from -1 to 1; 13 is the cell itself.
  std::uint64_t At(int k) const {
    return parts_[0][k % 3] | parts_[1][k / 3 % 3] | parts_[2][k / 9];
  }

 private:
  std::array<std::array<std::uint64_t, 3>, 3> parts_;  // by axis and step
};

}  // namespace planegraph
