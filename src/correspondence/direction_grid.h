#pragma once

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "planegraph/correspondence/patch_map.h"

namespace planegraph {

/// A map's surfaces as voxels, one layer of bits for each of 26 classes of directions: the table
/// that votes for translations are counted in, a square of sixteen of them at once.
class DirectionGrid {
 public:
  static constexpr int kClasses = 26;

  /// `voxel`: edge in metres; it grows where the map would need more than 2^26 voxels.
  DirectionGrid(const std::vector<Surfel>& surfels, double voxel);

  /// A surface that votes: its place relative to the body that is looked for, map axes, metres.
  struct Voter {
    Eigen::Vector3d place;
    int direction;  ///< ClassOf its normal, map axes
  };
  /// A translation with the number of voters that then lie on a surface that faces like them.
  struct Vote {
    Eigen::Vector3d translation;
    int count;
  };
  struct Window {
    Eigen::Vector3d low, high;  ///< of the translations that are tried
  };
  /// The translations (voxel centres) with the most votes, best first, none a neighbour of a better
  /// one. At most 255 voters count.
  std::vector<Vote> Count(const std::vector<Voter>& voters, const Window& window,
                          std::size_t most) const;

  static int ClassOf(const Eigen::Vector3d& normal);
  double voxel() const { return voxel_; }
  const Eigen::Vector3d& low() const { return low_; }
  Eigen::Vector3d high() const { return low_ + voxel_ * size_.cast<double>(); }

 private:
  struct Table;
  struct Reader;
  struct Stack;

  void Mark(const Surfel& surfel);
  void MarkPoint(const Eigen::Vector3d& point, const std::vector<int>& classes);
  Table CountAll(const std::vector<Voter>& voters, const Window& window) const;
  std::vector<Reader> ReadersOf(const std::vector<Voter>& voters, const Table& table) const;
  std::vector<Stack> StacksOf(const std::vector<Reader>& readers, int column, int y) const;
  void CountTiles(const std::vector<Stack>& stacks, int column, int y, Table* table) const;
  // Rows of a column that is sixteen voxels wide follow each other, first by y. Sixteen empty ones
  // lie before and after them, and an empty column on either side.
  std::ptrdiff_t Row(int column, int y, int z) const {
    return ((column + 1) * std::ptrdiff_t{size_.z()} + z) * (size_.y() + 16) + 16 + y;
  }

  double voxel_;
  Eigen::Vector3d low_ = Eigen::Vector3d::Zero();
  Eigen::Vector3i size_ = Eigen::Vector3i::Zero();
  int columns_ = 0;
  std::array<std::vector<std::uint16_t>, kClasses> layers_;  // empty: no surface of that class
};

}  // namespace planegraph
