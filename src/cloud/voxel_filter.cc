#include <cmath>
#include <string>
#include <unordered_map>

#include "planegraph/base/error.h"
#include "planegraph/cloud/filters.h"
#include "planegraph/cloud/voxel_key.h"

namespace planegraph {
namespace {

struct MixBits {
  std::size_t operator()(std::uint64_t key) const {
    key ^= key >> 31;
    key *= 0x9e3779b97f4a7c15ULL;
    return key ^ (key >> 29);
  }
};

std::uint64_t KeyOf(const Eigen::Vector3f& point, double size) {
  const std::uint64_t key = VoxelKey(point.cast<double>(), size);
  if (key != kNoVoxel) return key;
  throw UsageError("voxel: the cloud spans too many voxels of " + std::to_string(size) + " m");
}

// Sums over the points of one voxel.
struct Sums {
  double count = 0;
  Eigen::Vector3d point = Eigen::Vector3d::Zero(), normal = Eigen::Vector3d::Zero(),
                  color = Eigen::Vector3d::Zero();
  double intensity = 0;
};

void Accumulate(const Cloud& cloud, std::size_t i, Sums* sums) {
  sums->count += 1;
  sums->point += cloud.points[i].cast<double>();
  if (!cloud.normals.empty()) sums->normal += cloud.normals[i].cast<double>();
  if (!cloud.intensities.empty()) sums->intensity += cloud.intensities[i];
  if (!cloud.colors.empty()) {
    for (int c = 0; c < 3; ++c) sums->color[c] += cloud.colors[i][c];
  }
}

void StoreMean(const Sums& sums, std::size_t i, Cloud* out) {
  out->points[i] = (sums.point / sums.count).cast<float>();
  if (!out->normals.empty()) {
    const double length = sums.normal.norm();
    out->normals[i] = (sums.normal / (length > 0 ? length : 1.0)).cast<float>();
  }
  if (!out->intensities.empty()) {
    out->intensities[i] = static_cast<float>(sums.intensity / sums.count);
  }
  if (!out->colors.empty()) {
    for (int c = 0; c < 3; ++c) {
      out->colors[i][c] = static_cast<std::uint8_t>(std::lround(sums.color[c] / sums.count));
    }
  }
}

}  // namespace

Cloud VoxelFilter(const Cloud& cloud, double size, VoxelPoint point) {
  if (!(size > 0)) throw UsageError("voxel: the size must be positive");
  std::unordered_map<std::uint64_t, std::uint32_t, MixBits> voxels;
  voxels.reserve(cloud.size() / 4);
  std::vector<std::uint32_t> first;
  std::vector<Sums> sums;
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    const auto [it, added] =
        voxels.try_emplace(KeyOf(cloud.points[i], size), static_cast<std::uint32_t>(first.size()));
    if (added) first.push_back(static_cast<std::uint32_t>(i));
    if (point != VoxelPoint::kCentroid) continue;
    if (added) sums.emplace_back();
    Accumulate(cloud, i, &sums[it->second]);
  }
  Cloud out = Select(cloud, first);
  for (std::size_t i = 0; i < sums.size(); ++i) StoreMean(sums[i], i, &out);
  return out;
}

}  // namespace planegraph
