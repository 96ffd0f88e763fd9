#include "planegraph/cloud/saturated_returns.h"

#include <algorithm>
#include <numeric>

namespace planegraph {
namespace {

// The spike: a shell of half a per mille of the range; beside it, a shell five times as wide that
// must hold clearly fewer points, or the farthest points are a surface.
constexpr float kSpike = 5e-4f, kBeside = 3e-3f;
constexpr double kLeastShare = 0.002, kLeastCount = 20;

bool HasSpike(const std::vector<float>& ranges, float largest) {
  double spike = 0, beside = 0;
  for (const float r : ranges) {
    if (r > largest * (1 - kSpike)) {
      ++spike;
    } else if (r > largest * (1 - kBeside)) {
      ++beside;
    }
  }
  const double least = std::max(kLeastCount, kLeastShare * static_cast<double>(ranges.size()));
  return spike >= least && beside <= 0.5 * spike;
}

}  // namespace

std::vector<std::uint32_t> UnsaturatedReturns(const Cloud& cloud) {
  std::vector<std::uint32_t> kept(cloud.size());
  std::iota(kept.begin(), kept.end(), 0u);
  if (cloud.points.empty()) return kept;
  const Eigen::Vector3f centre = (cloud.viewpoint - cloud.offset).cast<float>();
  std::vector<float> ranges;
  ranges.reserve(cloud.size());
  for (const auto& p : cloud.points) ranges.push_back((p - centre).norm());
  const float largest = *std::max_element(ranges.begin(), ranges.end());
  if (!HasSpike(ranges, largest)) return kept;
  std::erase_if(kept, [&](std::uint32_t i) { return ranges[i] > largest * (1 - kSpike); });
  return kept;
}

Cloud DropSaturatedReturns(Cloud cloud) {
  const auto kept = UnsaturatedReturns(cloud);
  return kept.size() == cloud.size() ? std::move(cloud) : Select(cloud, kept);
}

}  // namespace planegraph
