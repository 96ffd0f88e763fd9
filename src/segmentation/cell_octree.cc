#include "segmentation/cell_octree.h"

#include <array>
#include <cmath>
#include <stdexcept>
#include <utility>

namespace planegraph {
namespace {

constexpr int kBitsPerAxis = 21;
constexpr std::uint32_t kEmpty = 0xffffffffu;

// Spreads the lowest 21 bits so that two zero bits follow each.
std::uint64_t Spread(std::uint64_t x) {
  x &= 0x1fffff;
  x = (x | x << 32) & 0x1f00000000ffff;
  x = (x | x << 16) & 0x1f0000ff0000ff;
  x = (x | x << 8) & 0x100f00f00f00f00f;
  x = (x | x << 4) & 0x10c30c30c30c30c3;
  x = (x | x << 2) & 0x1249249249249249;
  return x;
}

std::uint64_t Compact(std::uint64_t x) {
  x &= 0x1249249249249249;
  x = (x ^ (x >> 2)) & 0x10c30c30c30c30c3;
  x = (x ^ (x >> 4)) & 0x100f00f00f00f00f;
  x = (x ^ (x >> 8)) & 0x1f0000ff0000ff;
  x = (x ^ (x >> 16)) & 0x1f00000000ffff;
  x = (x ^ (x >> 32)) & 0x1fffff;
  return x;
}

std::uint64_t MortonKey(const Eigen::Vector3i& c) {
  return Spread(static_cast<std::uint64_t>(c.x())) |
         Spread(static_cast<std::uint64_t>(c.y())) << 1 |
         Spread(static_cast<std::uint64_t>(c.z())) << 2;
}

std::uint64_t HashKey(std::uint64_t key) {
  key ^= key >> 31;
  key *= 0x9e3779b97f4a7c15ull;
  return key ^ (key >> 29);
}

using KeyedIndex = std::pair<std::uint64_t, std::uint32_t>;

// Least significant digit radix sort, stable, only over the bits in use.
void RadixSort(std::vector<KeyedIndex>* values, std::uint64_t largest) {
  constexpr int kDigit = 11;
  std::vector<KeyedIndex> other(values->size());
  for (int shift = 0; shift < 64 && (largest >> shift) != 0; shift += kDigit) {
    std::array<std::uint32_t, (1 << kDigit) + 1> start{};
    constexpr std::uint64_t mask = (1 << kDigit) - 1;
    for (const auto& v : *values) ++start[((v.first >> shift) & mask) + 1];
    for (int i = 0; i < (1 << kDigit); ++i) start[i + 1] += start[i];
    for (const auto& v : *values) other[start[(v.first >> shift) & mask]++] = v;
    values->swap(other);
  }
}

Eigen::Vector3f Minimum(const std::vector<Eigen::Vector3f>& points) {
  Eigen::Vector3f minimum = points.front();
  for (const auto& p : points) minimum = minimum.cwiseMin(p);
  return minimum;
}

Eigen::Vector3f Maximum(const std::vector<Eigen::Vector3f>& points) {
  Eigen::Vector3f maximum = points.front();
  for (const auto& p : points) maximum = maximum.cwiseMax(p);
  return maximum;
}

}  // namespace

void CellSums::Add(const Eigen::Vector3f& point) {
  const double x = point.x(), y = point.y(), z = point.z();
  count += 1.0;
  sum.x() += x, sum.y() += y, sum.z() += z;
  xx += x * x, xy += x * y, xz += x * z, yy += y * y, yz += y * z, zz += z * z;
}

void CellSums::Add(const CellSums& other) {
  count += other.count;
  sum += other.sum;
  xx += other.xx, xy += other.xy, xz += other.xz;
  yy += other.yy, yz += other.yz, zz += other.zz;
}

Moments CellSums::ToMoments() const {
  Moments m;
  m.count = count;
  m.mean = sum / count;
  const Eigen::Vector3d& c = m.mean;
  m.scatter << xx - sum.x() * c.x(), xy - sum.x() * c.y(), xz - sum.x() * c.z(),
      xy - sum.x() * c.y(), yy - sum.y() * c.y(), yz - sum.y() * c.z(), xz - sum.x() * c.z(),
      yz - sum.y() * c.z(), zz - sum.z() * c.z();
  return m;
}

CellOctree::CellOctree(const Cloud& cloud, double cell_size, int levels) : cell_size_(cell_size) {
  if (cloud.points.empty()) {
    levels_.resize(levels);
    tables_.resize(levels);
    for (int level = 0; level < levels; ++level) BuildTable(level);
    return;
  }
  BuildFinest(SortPoints(cloud));
  while (static_cast<int>(levels_.size()) < levels) BuildNext();
  tables_.resize(levels);
  for (int level = 0; level < levels; ++level) BuildTable(level);
}

std::vector<std::uint64_t> CellOctree::SortPoints(const Cloud& cloud) {
  // The grid starts one coarse cell below the smallest coordinate, so neighbours never underflow.
  const Eigen::Vector3d origin = Minimum(cloud.points).cast<double>().array() - 64.0 * cell_size_;
  const double extent = (Maximum(cloud.points).cast<double>() - origin).maxCoeff() / cell_size_;
  if (!(extent < static_cast<double>((1 << kBitsPerAxis) - 64))) {
    throw std::length_error("the cloud's extent is too large for its cell size");
  }
  std::vector<KeyedIndex> keyed(cloud.size());
  std::uint64_t used = 0;
  const double inverse = 1.0 / cell_size_;
  for (std::uint32_t i = 0; i < keyed.size(); ++i) {
    const Eigen::Vector3i c = ((cloud.points[i].cast<double>() - origin) * inverse).cast<int>();
    keyed[i] = {MortonKey(c), i};
    used |= keyed[i].first;
  }
  RadixSort(&keyed, used);
  std::vector<std::uint64_t> keys(keyed.size());
  order_.resize(keyed.size());
  sorted_points_.resize(keyed.size());
  for (std::size_t i = 0; i < keyed.size(); ++i) {
    keys[i] = keyed[i].first;
    order_[i] = keyed[i].second;
    sorted_points_[i] = cloud.points[order_[i]];
  }
  return keys;
}

void CellOctree::BuildFinest(const std::vector<std::uint64_t>& keys) {
  levels_.emplace_back();
  auto& cells = levels_.back();
  for (std::uint32_t i = 0; i < keys.size(); ++i) {
    if (cells.empty() || cells.back().key != keys[i]) cells.push_back({keys[i], i, 0, 0, 0, 0, {}});
    cells.back().point_count++;
    cells.back().sums.Add(sorted_points_[i]);
  }
}

void CellOctree::BuildNext() {
  std::vector<Cell> cells;
  auto& below = levels_.back();
  for (std::uint32_t i = 0; i < below.size(); ++i) {
    const std::uint64_t key = below[i].key >> 3;
    if (cells.empty() || cells.back().key != key) {
      cells.push_back({key, below[i].first_point, 0, i, 0, 0, {}});
    }
    cells.back().point_count += below[i].point_count;
    cells.back().child_count++;
    cells.back().sums.Add(below[i].sums);
    below[i].parent = static_cast<std::uint32_t>(cells.size() - 1);
  }
  levels_.push_back(std::move(cells));
}

void CellOctree::BuildTable(int level) {
  const auto& cells = levels_[level];
  std::size_t size = 16;
  while (size < 2 * cells.size()) size *= 2;
  HashTable& table = tables_[level];
  table.mask = size - 1;
  table.slots.assign(size, kEmpty);
  for (std::uint32_t i = 0; i < cells.size(); ++i) {
    std::uint64_t slot = HashKey(cells[i].key) & table.mask;
    while (table.slots[slot] != kEmpty) slot = (slot + 1) & table.mask;
    table.slots[slot] = i;
  }
}

int CellOctree::Find(int level, const Eigen::Vector3i& coordinates) const {
  const std::uint64_t key = MortonKey(coordinates);
  const HashTable& table = tables_[level];
  for (std::uint64_t slot = HashKey(key) & table.mask; table.slots[slot] != kEmpty;
       slot = (slot + 1) & table.mask) {
    if (levels_[level][table.slots[slot]].key == key) return static_cast<int>(table.slots[slot]);
  }
  return -1;
}

Eigen::Vector3i CellOctree::Coordinates(std::uint64_t key) {
  return {static_cast<int>(Compact(key)), static_cast<int>(Compact(key >> 1)),
          static_cast<int>(Compact(key >> 2))};
}

}  // namespace planegraph
