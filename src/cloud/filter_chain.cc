#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>

#include "planegraph/base/error.h"
#include "planegraph/cloud/filters.h"
#include "planegraph/cloud/normals.h"

namespace planegraph {
namespace {

using Parameters = std::map<std::string, double>;

struct Filter {
  FilterDescription description;
  std::function<Cloud(Cloud, const Parameters&, int)> apply;
};

std::size_t Count(double value) { return static_cast<std::size_t>(value); }

const std::vector<Filter>& Filters() {
  static const std::vector<Filter> kFilters = {
      {{"voxel",
        "one point per voxel of `size` metres: the centroid, or the first",
        {{"size", 0.05}, {"centroid", 1}}},
       [](Cloud cloud, const Parameters& p, int) {
         const bool mean = p.at("centroid") != 0;
         return VoxelFilter(cloud, p.at("size"), mean ? VoxelPoint::kCentroid : VoxelPoint::kFirst);
       }},
      {{"outlier", "drops points far from their k nearest neighbours", {{"k", 50}, {"stddev", 1}}},
       [](Cloud cloud, const Parameters& p, int threads) {
         return OutlierFilter(cloud, Count(p.at("k")), p.at("stddev"), threads);
       }},
      {{"range",
        "keeps points from `min` to `max` metres off the sensor",
        {{"min", 0}, {"max", std::numeric_limits<double>::infinity()}}},
       [](Cloud cloud, const Parameters& p, int) {
         return RangeFilter(cloud, p.at("min"), p.at("max"));
       }},
      {{"incidence",
        "drops points met at more than `max_deg` from their normal",
        {{"max_deg", 80}}},
       [](Cloud cloud, const Parameters& p, int) {
         return IncidenceFilter(cloud, p.at("max_deg"));
       }},
      {{"normals", "normals from the k nearest neighbours", {{"k", 20}}},
       [](Cloud cloud, const Parameters& p, int threads) {
         return WithNormals(std::move(cloud), Count(p.at("k")), threads);
       }},
  };
  return kFilters;
}

const Filter& FindFilter(const std::string& name) {
  std::string known;
  for (const Filter& filter : Filters()) {
    if (filter.description.name == name) return filter;
    known += (known.empty() ? "" : ", ") + filter.description.name;
  }
  throw UsageError("unknown filter `" + name + "` (there are " + known + ")");
}

void CheckValue(const std::string& filter, const std::string& parameter, double value) {
  const bool positive = parameter == "size" || parameter == "k";
  if (std::isnan(value) || value < 0 || (positive && value <= 0)) {
    throw UsageError("filter `" + filter + "`: `" + parameter + "` must be " +
                     (positive ? "positive" : "0 or more"));
  }
  if (parameter == "k" && (value > 10000 || value != std::floor(value))) {
    throw UsageError("filter `" + filter + "`: `k` must be a whole number up to 10000");
  }
}

FilterStep Complete(const FilterStep& step) {
  FilterStep complete{step.name, FindFilter(step.name).description.defaults};
  for (const auto& [parameter, value] : step.parameters) {
    const auto it = complete.parameters.find(parameter);
    if (it == complete.parameters.end()) {
      throw UsageError("filter `" + step.name + "` has no parameter `" + parameter + "`");
    }
    CheckValue(step.name, parameter, value);
    it->second = value;
  }
  return complete;
}

}  // namespace

const std::vector<FilterDescription>& ListFilters() {
  static const std::vector<FilterDescription> kList = [] {
    std::vector<FilterDescription> list;
    for (const Filter& filter : Filters()) list.push_back(filter.description);
    return list;
  }();
  return kList;
}

FilterChain::FilterChain(std::vector<FilterStep> steps) : steps_(std::move(steps)) {
  for (FilterStep& step : steps_) step = Complete(step);
}

Cloud FilterChain::Apply(Cloud cloud, int threads) const {
  for (const FilterStep& step : steps_) {
    cloud = FindFilter(step.name).apply(std::move(cloud), step.parameters, threads);
  }
  return cloud;
}

}  // namespace planegraph
