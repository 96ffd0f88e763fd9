#include "pipeline/map_colours.h"

#include <algorithm>

namespace planegraph {
namespace {

constexpr std::uint32_t kEnoughPoints = 1 << 16;  // for a mean; the sums stay within 32 bits

std::uint64_t Mix(std::uint64_t key) {
  key *= 0x9e3779b97f4a7c15ull;
  return key ^ (key >> 32);
}

// The segmentation's finest cells hold about nine points each, which is three spacings an edge.
double VoxelOf(const PlaneSet& planes) {
  constexpr double kWithoutPatches = 0.2;
  double finest = planes.patches.empty() ? kWithoutPatches : planes.patches.front().size;
  for (const Patch& patch : planes.patches) finest = std::min(finest, patch.size);
  return finest;
}

std::vector<Surfel> SurfelsIn(const PlaneSet& planes, const SeenParts& seen, double gate) {
  std::vector<Surfel> surfels = MakeSurfels(planes);
  std::erase_if(surfels, [&](const Surfel& s) { return !seen.Reach(s.mean, gate + 2 * s.size); });
  surfels.shrink_to_fit();
  return surfels;
}

}  // namespace

void VoxelColours::Add(const Cloud& cloud) {
  for (std::size_t i = 0; i < cloud.colors.size(); ++i) {
    const std::uint64_t key = VoxelKey(cloud.Position(i), voxel_);
    if (key == kNoVoxel) continue;
    Slot& slot = SlotOf(key);
    if (slot.count == kEnoughPoints) continue;
    ++slot.count;
    for (int c = 0; c < 3; ++c) slot.sum[c] += cloud.colors[i][c];
    if (2 * voxels_ > slots_.size()) Grow();
  }
}

VoxelColours::Slot& VoxelColours::SlotOf(std::uint64_t key) {
  const std::uint64_t mask = slots_.size() - 1;
  std::uint64_t at = Mix(key) & mask;
  while (slots_[at].key != kNoVoxel && slots_[at].key != key) at = (at + 1) & mask;
  if (slots_[at].key == kNoVoxel) ++voxels_;
  slots_[at].key = key;
  return slots_[at];
}

void VoxelColours::Grow() {
  std::vector<Slot> old(2 * slots_.size());
  old.swap(slots_);
  voxels_ = 0;
  for (const Slot& slot : old) {
    if (slot.key != kNoVoxel) SlotOf(slot.key) = slot;
  }
}

std::optional<Rgb> VoxelColours::At(const Eigen::Vector3d& point) const {
  const std::uint64_t key = VoxelKey(point, voxel_);
  if (key == kNoVoxel) return std::nullopt;
  const std::uint64_t mask = slots_.size() - 1;
  std::uint64_t at = Mix(key) & mask;
  while (slots_[at].key != kNoVoxel && slots_[at].key != key) at = (at + 1) & mask;
  const Slot& slot = slots_[at];
  if (slot.key == kNoVoxel) return std::nullopt;
  Rgb mean;
  for (int c = 0; c < 3; ++c) {
    mean[c] = static_cast<std::uint8_t>((slot.sum[c] + slot.count / 2) / slot.count);
  }
  return mean;
}

MapColours::MapColours(const PlaneSet& planes, double gate)
    : voxels_(VoxelOf(planes)), surfaces_(MakeSurfels(planes)), gate_(gate) {}

bool SeenParts::Reach(const Eigen::Vector3d& place, double slack) const {
  return std::any_of(balls_.begin(), balls_.end(), [&](const auto& ball) {
    return (place - ball.first).norm() <= ball.second + slack;
  });
}

MapColours::MapColours(const PlaneSet& planes, double gate, SeenParts seen)
    : voxels_(VoxelOf(planes)),
      surfaces_(SurfelsIn(planes, seen, gate)),
      gate_(gate),
      seen_(std::move(seen)) {}

void MapColours::Add(const Cloud& cloud) {
  if (!seen_ || cloud.size() == 0) return voxels_.Add(cloud);
  Eigen::Vector3d low = cloud.Position(0), high = low;
  for (std::size_t i = 1; i < cloud.size(); ++i) {
    low = low.cwiseMin(cloud.Position(i));
    high = high.cwiseMax(cloud.Position(i));
  }
  // A colour is looked up at a point, or at its foot on a surface within the gate.
  const double slack = (high - low).norm() / 2 + gate_ + 2 * voxels_.voxel();
  if (seen_->Reach((low + high) / 2, slack)) voxels_.Add(cloud);
}

std::optional<Rgb> MapColours::OnPlane(const Eigen::Vector3d& point,
                                       const Eigen::Vector3d& normal) const {
  constexpr double kLeastCosine = 0.8;
  const int found = surfaces_.Find(point, normal, gate_, kLeastCosine);
  if (found < 0) return std::nullopt;
  // The map's points lie on the map's surface, by its error off the laser's.
  const Surfel& surfel = surfaces_.surfels()[static_cast<std::size_t>(found)];
  const double height = surfel.normal.dot(point - surfel.mean);
  const auto colour = voxels_.At(point - height * surfel.normal);
  return colour ? colour : voxels_.At(point);
}

}  // namespace planegraph
