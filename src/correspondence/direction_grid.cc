#include "correspondence/direction_grid.h"

#include <algorithm>
#include <cmath>
#include <cstring>

#include "correspondence/tile_counters.h"

namespace planegraph {
namespace {

constexpr double kMostVoxels = 1 << 26;
// A surface counts for all classes within this angle: half the distance of two classes, and what a
// rotation may be off.
const double kClassReach = std::cos(35.0 * 3.14159265358979 / 180.0);

const std::array<Eigen::Vector3d, DirectionGrid::kClasses>& ClassDirections() {
  static const auto directions = [] {
    std::array<Eigen::Vector3d, DirectionGrid::kClasses> all;
    for (int k = 0, c = 0; k < 27; ++k) {
      if (k == 13) continue;
      all[c++] = Eigen::Vector3d(k % 3 - 1, k / 3 % 3 - 1, k / 9 - 1).normalized();
    }
    return all;
  }();
  return directions;
}

std::vector<int> ClassesNear(const Eigen::Vector3d& normal) {
  std::vector<int> classes;
  for (int c = 0; c < DirectionGrid::kClasses; ++c) {
    if (ClassDirections()[c].dot(normal) > kClassReach) classes.push_back(c);
  }
  return classes;
}

// The count from which on at most `most` cells lie.
int Threshold(const std::vector<std::uint8_t>& counts, std::size_t most) {
  // Neighbours are often equal: each of four has a histogram of its own.
  std::array<std::array<std::uint32_t, 4>, 256> histogram{};
  const std::size_t size = counts.size();
  for (std::size_t k = 0; k < size; ++k) ++histogram[counts[k]][k % 4];
  std::size_t above = 0;
  for (int c = 255; c > 0; --c) {
    for (const std::uint32_t n : histogram[c]) above += n;
    if (above > most) return c + 1;
  }
  return 1;
}

}  // namespace

// Where translations are tried: integer steps of the voxel from `first`.
struct DirectionGrid::Table {
  Eigen::Vector3i first, size;
  std::vector<std::uint8_t> counts;

  std::size_t Row(int y, int z) const {
    return (static_cast<std::size_t>(z) * size.y() + y) * size.x();
  }
};

// A voter's layer, shifted: cell t of the table stands for the map's voxel t + shift.
struct DirectionGrid::Reader {
  const std::uint16_t* layer;
  int column, bit;  // where the table's rows begin
  int y, z;         // shift
};

// What a voter has for a stack of the table's tiles: a tile and its neighbour for each z.
struct DirectionGrid::Stack {
  const std::uint16_t* layer;
  std::ptrdiff_t left, right;  // in it, at the table's lowest z
  int bit, first, last;        // from this z on, before that
};

int DirectionGrid::ClassOf(const Eigen::Vector3d& normal) {
  int best = 0;
  double cosine = -INFINITY;
  for (int c = 0; c < kClasses; ++c) {
    const double other = ClassDirections()[c].dot(normal);
    if (other > cosine) cosine = other, best = c;
  }
  return best;
}

DirectionGrid::DirectionGrid(const std::vector<Surfel>& surfels, double voxel) : voxel_(voxel) {
  if (surfels.empty()) return;
  Eigen::Vector3d low = surfels.front().mean, high = low;
  for (const Surfel& s : surfels) {
    low = low.cwiseMin(s.mean - Eigen::Vector3d::Constant(s.size));
    high = high.cwiseMax(s.mean + Eigen::Vector3d::Constant(s.size));
  }
  const Eigen::Vector3d extent = (high - low).array() + 2.0 * voxel;
  voxel_ = std::max(voxel, std::cbrt(extent.prod() / kMostVoxels));
  low_ = low.array() - voxel_;
  size_ = (extent / voxel_).array().ceil().cast<int>() + 1;
  columns_ = (size_.x() + 15) / 16;
  for (const Surfel& s : surfels) Mark(s);
}

void DirectionGrid::Mark(const Surfel& s) {
  const std::vector<int> classes = ClassesNear(s.normal);
  const int steps = std::max(1, static_cast<int>(std::ceil(s.size / voxel_)));
  const Eigen::Vector3d across = s.normal.cross(s.axis1);
  for (int a = -steps; a <= steps; ++a) {
    for (int b = -steps; b <= steps; ++b) {
      const double u = 0.5 * s.size * a / steps, v = 0.5 * s.size * b / steps;
      for (const double off : {-0.5, 0.0, 0.5}) {
        MarkPoint(s.mean + u * s.axis1 + v * across + off * voxel_ * s.normal, classes);
      }
    }
  }
}

void DirectionGrid::MarkPoint(const Eigen::Vector3d& point, const std::vector<int>& classes) {
  const Eigen::Vector3i at = ((point - low_) / voxel_).array().floor().cast<int>();
  if (at.minCoeff() < 0 || (at - size_).maxCoeff() >= 0) return;
  for (const int c : classes) {
    if (layers_[c].empty()) layers_[c].assign(Row(columns_ + 1, 0, 0), 0);
    layers_[c][Row(at.x() / 16, at.y(), at.z())] |= static_cast<std::uint16_t>(1u << at.x() % 16);
  }
}

std::vector<DirectionGrid::Reader> DirectionGrid::ReadersOf(const std::vector<Voter>& voters,
                                                            const Table& table) const {
  std::vector<Reader> readers;
  for (std::size_t k = 0; k < std::min<std::size_t>(voters.size(), TileCounters::kMost); ++k) {
    const auto& layer = layers_[voters[k].direction];
    if (layer.empty()) continue;
    const Eigen::Vector3i shift =
        (voters[k].place / voxel_).array().round().cast<int>() + table.first.array();
    const int bit = shift.x() & 15;
    readers.push_back({layer.data(), (shift.x() - bit) / 16, bit, shift.y(), shift.z()});
  }
  return readers;
}

std::vector<DirectionGrid::Stack> DirectionGrid::StacksOf(const std::vector<Reader>& readers,
                                                          int column, int y) const {
  std::vector<Stack> stacks;
  for (const Reader& r : readers) {
    const int left = r.column + column, first = r.y + y;
    if (left < -1 || left >= columns_ || first <= -16 || first >= size_.y()) continue;
    stacks.push_back(
        {r.layer, Row(left, first, r.z), Row(left + 1, first, r.z), r.bit, -r.z, size_.z() - r.z});
  }
  return stacks;
}

void DirectionGrid::CountTiles(const std::vector<Stack>& stacks, int column, int y,
                               Table* table) const {
  const std::ptrdiff_t step = Row(0, 0, 1) - Row(0, 0, 0);
  const int width = std::min(16, table->size.x() - 16 * column);
  std::array<std::uint8_t, 16> row;
  for (int z = 0; z < table->size.z(); ++z) {
    TileCounters counters;
    for (const Stack& s : stacks) {
      if (z < s.first || z >= s.last) continue;
      counters.Add(s.layer + s.left + z * step, s.layer + s.right + z * step, s.bit);
    }
    counters.Finish();
    for (int k = 0; k < std::min(16, table->size.y() - y); ++k) {
      counters.Write(k, &row);
      std::memcpy(&table->counts[table->Row(y + k, z) + 16 * column], row.data(), width);
    }
  }
}

DirectionGrid::Table DirectionGrid::CountAll(const std::vector<Voter>& voters,
                                             const Window& window) const {
  Table table;
  table.first = ((window.low - low_) / voxel_).array().floor().cast<int>();
  table.size = ((window.high - low_) / voxel_).array().floor().cast<int>();
  table.size = (table.size - table.first).cwiseMax(0).array() + 1;
  table.counts.resize(table.Row(0, table.size.z()));
  const std::vector<Reader> readers = ReadersOf(voters, table);
  for (int column = 0; 16 * column < table.size.x(); ++column) {
    for (int y = 0; y < table.size.y(); y += 16) {
      CountTiles(StacksOf(readers, column, y), column, y, &table);
    }
  }
  return table;
}

std::vector<DirectionGrid::Vote> DirectionGrid::Count(const std::vector<Voter>& voters,
                                                      const Window& window,
                                                      std::size_t most) const {
  const Table table = CountAll(voters, window);
  const int threshold = Threshold(table.counts, 16 * most);
  std::vector<Vote> votes;
  const std::uint8_t* counts = table.counts.data();
  for (std::size_t k = 0, size = table.counts.size(); k < size; ++k) {
    if (counts[k] < threshold) continue;
    const auto row = static_cast<int>(k / table.size.x());
    const Eigen::Vector3i at(static_cast<int>(k % table.size.x()), row % table.size.y(),
                             row / table.size.y());
    const Eigen::Vector3d cell = (at + table.first).cast<double>();
    votes.push_back({low_ + voxel_ * (cell.array() + 0.5).matrix(), counts[k]});
  }
  std::stable_sort(votes.begin(), votes.end(),
                   [](const Vote& a, const Vote& b) { return a.count > b.count; });
  std::vector<Vote> distinct;
  for (const Vote& vote : votes) {
    if (distinct.size() == most) break;
    const bool known = std::any_of(distinct.begin(), distinct.end(), [&](const Vote& d) {
      return (d.translation - vote.translation).cwiseAbs().maxCoeff() < 1.5 * voxel_;
    });
    if (!known) distinct.push_back(vote);
  }
  return distinct;
}

}  // namespace planegraph
