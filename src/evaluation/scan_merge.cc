#include "planegraph/evaluation/scan_merge.h"

#include <bit>
#include <cmath>
#include <cstdint>
#include <limits>
#include <vector>

#include "planegraph/base/error.h"
#include "planegraph/cloud/voxel_key.h"

namespace planegraph {
namespace {

// A set of keys in one flat table: a node per key, as std::unordered_set has it, costs more than
// all else that is done with a map's points.
class KeySet {
 public:
  explicit KeySet(std::size_t most) {
    std::size_t size = 64;
    while (size < 2 * most) size *= 2;
    slots_.assign(size, kNoVoxel);
    mask_ = size - 1;
  }
  // False where the key is there already.
  bool Insert(std::uint64_t key) {
    std::uint64_t hash = (key ^ (key >> 31)) * 0x9E3779B97F4A7C15ull;
    std::uint64_t slot = (hash ^ (hash >> 32)) & mask_;
    while (slots_[slot] != kNoVoxel && slots_[slot] != key) slot = (slot + 1) & mask_;
    const bool fresh = slots_[slot] == kNoVoxel;
    slots_[slot] = key;
    return fresh;
  }

 private:
  std::vector<std::uint64_t> slots_;
  std::uint64_t mask_ = 0;
};

}  // namespace

std::uint64_t Fingerprint(const Cloud& cloud, std::uint64_t before) {
  constexpr std::uint64_t kPrime = 0x100000001B3ull;
  std::uint64_t hash = (before ^ cloud.size()) * kPrime;
  for (const Eigen::Vector3f& point : cloud.points) {
    for (int axis = 0; axis < 3; ++axis) {
      hash = (hash ^ std::bit_cast<std::uint32_t>(point[axis])) * kPrime;
    }
  }
  return hash;
}

std::vector<std::uint32_t> FirstOfEachVoxel(const Cloud& cloud, double voxel) {
  KeySet occupied(cloud.size());
  std::vector<std::uint32_t> first;
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    const std::uint64_t key = VoxelKey(cloud.Position(i), voxel);
    if (key == kNoVoxel) throw UsageError("the voxel is too small for the scan");
    if (occupied.Insert(key)) first.push_back(static_cast<std::uint32_t>(i));
  }
  return first;
}

void ScanMerger::Add(const Cloud& scan, const Rigid3& world_from_scan) {
  if (!offset_) offset_ = world_from_scan.translation;
  merged_.offset = *offset_;
  const double farthest =
      options_.max_range > 0.0 ? options_.max_range : std::numeric_limits<double>::infinity();
  std::vector<std::uint32_t> in_range;
  for (std::size_t i = 0; i < scan.size(); ++i) {
    const double range = scan.Position(i).norm();
    if (range < options_.min_range || range > farthest) continue;
    in_range.push_back(static_cast<std::uint32_t>(i));
  }
  Cloud kept = Select(scan, in_range);
  if (options_.voxel > 0.0) kept = Select(kept, FirstOfEachVoxel(kept, options_.voxel));
  fingerprint_ = Fingerprint(kept, fingerprint_);
  for (std::size_t i = 0; i < kept.size(); ++i) {
    const Eigen::Vector3d position = world_from_scan * kept.Position(i) - *offset_;
    merged_.points.push_back(position.cast<float>());
  }
}

}  // namespace planegraph
