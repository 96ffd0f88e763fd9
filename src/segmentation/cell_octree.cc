#include "segmentation/cell_octree.h"

#include <array>
#include <cmath>
#include <stdexcept>
#include <utility>

namespace planegraph {
namespace {

constexpr int kBitsPerAxis = 21;
constexpr std::uint32_t kEmpty = 0xffffffffu;
constexpr std::uint64_t kEveryThird = 0x1249249249249249;  // bits of one axis

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

// Runs of equal keys: the number of cells to come, so that no list of them has to grow.
template <typename T, typename KeyOf>
std::size_t CountRuns(const std::vector<T>& values, const KeyOf& key_of) {
  std::size_t runs = values.empty() ? 0 : 1;
  for (std::size_t i = 1; i < values.size(); ++i)
    runs += key_of(values[i]) != key_of(values[i - 1]);
  return runs;
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
    sums_.resize(levels);
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
  sums_.emplace_back();
  auto& cells = levels_.back();
  cells.reserve(CountRuns(keys, [](std::uint64_t key) { return key; }));
  for (std::uint32_t i = 0; i < keys.size(); ++i) {
    if (cells.empty() || cells.back().key != keys[i]) cells.push_back({keys[i], i, 0, 0, 0});
    cells.back().point_count++;
  }
}

CellSums CellOctree::FinestSums(const Cell& cell) const {
  CellSums sums;
  for (std::uint32_t i = 0; i < cell.point_count; ++i) {
    sums.Add(sorted_points_[cell.first_point + i]);
  }
  return sums;
}

void CellOctree::BuildNext() {
  std::vector<Cell> cells;
  std::vector<CellSums> sums;
  const auto& below = levels_.back();
  const int level_below = levels() - 1;
  cells.reserve(CountRuns(below, [](const Cell& cell) { return cell.key >> 3; }));
  sums.reserve(cells.capacity());
  for (std::uint32_t i = 0; i < below.size(); ++i) {
    const std::uint64_t key = below[i].key >> 3;
    if (cells.empty() || cells.back().key != key) {
      cells.push_back({key, below[i].first_point, 0, i, 0});
      sums.emplace_back();
    }
    cells.back().point_count += below[i].point_count;
    cells.back().child_count++;
    sums.back().Add(Sums(level_below, i));
  }
  levels_.push_back(std::move(cells));
  sums_.push_back(std::move(sums));
}

void CellOctree::BuildTable(int level) {
  const auto& cells = levels_[level];
  std::size_t size = 16;
  while (3 * size < 4 * cells.size()) size *= 2;
  HashTable& table = tables_[level];
  table.mask = size - 1;
  table.slots.assign(size, {kEmpty, 0});
  for (std::uint32_t i = 0; i < cells.size(); ++i) {
    const std::uint64_t hash = HashKey(cells[i].key);
    std::uint64_t slot = hash & table.mask;
    while (table.slots[slot].cell != kEmpty) slot = (slot + 1) & table.mask;
    table.slots[slot] = {i, static_cast<std::uint32_t>(hash >> 32)};
  }
}

int CellOctree::Find(int level, const Eigen::Vector3i& coordinates) const {
  return Find(level, MortonKey(coordinates));
}

int CellOctree::Find(int level, std::uint64_t key) const {
  const HashTable& table = tables_[level];
  const std::uint64_t hash = HashKey(key);
  const auto tag = static_cast<std::uint32_t>(hash >> 32);
  for (std::uint64_t at = hash & table.mask;; at = (at + 1) & table.mask) {
    const Slot slot = table.slots[at];
    if (slot.cell == kEmpty) return -1;
    if (slot.tag == tag && levels_[level][slot.cell].key == key) return static_cast<int>(slot.cell);
  }
}

Eigen::Vector3i CellOctree::Coordinates(std::uint64_t key) {
  return {static_cast<int>(Compact(key)), static_cast<int>(Compact(key >> 1)),
          static_cast<int>(Compact(key >> 2))};
}

NeighbourKeys::NeighbourKeys(std::uint64_t key) {
  for (int axis = 0; axis < 3; ++axis) {
    const std::uint64_t mask = kEveryThird << axis, one = std::uint64_t{1} << axis;
    // With ones in all other bits a carry passes over them; with zeros a borrow does.
    parts_[axis] = {((key & mask) - one) & mask, key & mask, ((key | ~mask) + one) & mask};
  }
}

}  // namespace planegraph
