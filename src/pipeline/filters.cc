#include "planegraph/pipeline/filters.h"

#include <algorithm>
#include <cmath>

#include "planegraph/base/error.h"

namespace planegraph {
namespace {

constexpr float kRobotRadius = 0.5f;  // metres

std::vector<float> Ranges(const Cloud& cloud) {
  const Eigen::Vector3f centre = (cloud.viewpoint - cloud.offset).cast<float>();
  std::vector<float> ranges;
  ranges.reserve(cloud.size());
  for (const auto& p : cloud.points) ranges.push_back((p - centre).norm());
  return ranges;
}

// Keeps the points whose range passes `keep`.
template <typename Keep>
std::size_t FilterByRange(Cloud* cloud, const std::vector<float>& ranges, Keep keep) {
  std::vector<std::uint32_t> kept;
  kept.reserve(ranges.size());
  for (std::uint32_t i = 0; i < ranges.size(); ++i) {
    if (keep(ranges[i])) kept.push_back(i);
  }
  const std::size_t dropped = ranges.size() - kept.size();
  if (dropped > 0) *cloud = Select(*cloud, kept);
  return dropped;
}

double Parameter(const FilterStep& step, const std::string& name, double fallback) {
  const auto found = step.parameters.find(name);
  return found == step.parameters.end() ? fallback : found->second;
}

void ApplyRange(const FilterStep& step, Cloud* cloud) {
  for (const auto& [name, value] : step.parameters) {
    if (name != "min" && name != "max") throw UsageError("filter range has no parameter " + name);
  }
  const double least = Parameter(step, "min", 0.0), most = Parameter(step, "max", INFINITY);
  FilterByRange(cloud, Ranges(*cloud), [&](float r) { return r >= least && r <= most; });
}

}  // namespace

std::size_t DropSaturatedReturns(Cloud* cloud) {
  if (cloud->points.empty()) return 0;
  constexpr float kSame = 0.001f;
  constexpr double kShare = 0.002;
  const std::vector<float> ranges = Ranges(*cloud);
  const float largest = *std::max_element(ranges.begin(), ranges.end());
  const auto saturated = std::count_if(ranges.begin(), ranges.end(),
                                       [&](float r) { return r > largest - kSame; });
  if (static_cast<double>(saturated) < std::max(20.0, kShare * static_cast<double>(ranges.size()))) {
    return 0;
  }
  return FilterByRange(cloud, ranges, [&](float r) { return r <= largest - kSame; });
}

void ApplyFilters(const std::vector<FilterStep>& steps, Cloud* cloud) {
  DropSaturatedReturns(cloud);
  if (steps.empty()) {
    FilterByRange(cloud, Ranges(*cloud), [](float r) { return r >= kRobotRadius; });
    return;
  }
  for (const FilterStep& step : steps) {
    if (step.name != "range") throw UsageError("unknown filter '" + step.name + "'");
    ApplyRange(step, cloud);
  }
}

}  // namespace planegraph
