#include "planegraph/correspondence/scan_group.h"

#include <algorithm>
#include <cmath>

#include "correspondence/same_direction.h"

namespace planegraph {

ScanGroup Around(const ScanGroup& group, std::size_t anchor, double radius) {
  const Rigid3 anchor_from_group = group.group_from_scan[anchor].Inverse();
  ScanGroup around;
  for (std::size_t k = 0; k < group.scans.size(); ++k) {
    const Rigid3 anchor_from_scan = anchor_from_group * group.group_from_scan[k];
    if (k != anchor && anchor_from_scan.translation.norm() > radius) continue;
    around.scans.push_back(group.scans[k]);
    around.group_from_scan.push_back(k == anchor ? Rigid3() : anchor_from_scan);
  }
  return around;
}

std::vector<std::size_t> Anchors(const ScanGroup& group, double distance, std::size_t most) {
  std::vector<std::size_t> anchors{0};
  while (anchors.size() < std::min(most, group.scans.size())) {
    std::size_t farthest = 0;
    double best = distance;
    for (std::size_t k = 0; k < group.scans.size(); ++k) {
      double nearest = INFINITY;
      for (const std::size_t a : anchors) {
        nearest = std::min(
            nearest,
            (group.group_from_scan[k].translation - group.group_from_scan[a].translation).norm());
      }
      if (nearest > best) best = nearest, farthest = k;
    }
    if (farthest == 0) break;
    anchors.push_back(farthest);
  }
  return anchors;
}

std::vector<GroupSample> SamplesOf(const ScanGroup& group, std::size_t most_per_scan) {
  std::vector<GroupSample> samples;
  for (std::size_t s = 0; s < group.scans.size(); ++s) {
    const ScanModel& scan = *group.scans[s];
    const Rigid3& pose = group.group_from_scan[s];
    const std::size_t stride =
        1 + (scan.samples.size() - 1) / std::max<std::size_t>(most_per_scan, 1);
    const std::size_t first = samples.size();
    double total = 0.0;
    for (std::size_t k = 0; k < scan.samples.size(); k += stride) {
      const Surfel& surfel = scan.map.surfels()[scan.samples[k]];
      samples.push_back({pose * surfel.mean, pose.rotation * surfel.normal, scan.sample_weights[k],
                         s, scan.samples[k]});
      total += scan.sample_weights[k];
    }
    for (std::size_t k = first; k < samples.size(); ++k) samples[k].weight /= total;
  }
  return samples;
}

std::vector<DirectionCluster> DirectionsOf(const ScanGroup& group) {
  constexpr std::size_t kMost = 16;
  std::vector<DirectionCluster> merged;
  for (std::size_t s = 0; s < group.scans.size(); ++s) {
    for (const DirectionCluster& cluster : group.scans[s]->directions) {
      const Eigen::Vector3d direction = group.group_from_scan[s].rotation * cluster.direction;
      const double area = cluster.weight * cluster.weight;
      const auto same = std::find_if(merged.begin(), merged.end(), [&](const auto& m) {
        return m.direction.dot(direction) > kOneDirection;
      });
      if (same == merged.end()) {
        merged.push_back({direction, area, {}});
      } else {
        same->direction = (same->weight * same->direction + area * direction).normalized();
        same->weight += area;
      }
    }
  }
  for (auto& cluster : merged) cluster.weight = std::sqrt(cluster.weight);
  std::stable_sort(merged.begin(), merged.end(),
                   [](const auto& a, const auto& b) { return a.weight > b.weight; });
  if (merged.size() > kMost) merged.resize(kMost);
  return merged;
}

}  // namespace planegraph
