#include "planegraph/correspondence/scan_model.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "correspondence/same_direction.h"

namespace planegraph {
namespace {

constexpr std::size_t kMostPlanes = 80;  // for directions and votes
constexpr std::size_t kMostDirections = 16;
constexpr std::size_t kSamples = 256;

std::vector<std::int32_t> LargestPlanes(const PlaneSet& set) {
  std::vector<std::int32_t> order(set.planes.size());
  std::iota(order.begin(), order.end(), 0);
  std::stable_sort(order.begin(), order.end(), [&](std::int32_t a, std::int32_t b) {
    return set.planes[a].area > set.planes[b].area;
  });
  if (order.size() > kMostPlanes) order.resize(kMostPlanes);
  return order;
}

std::vector<DirectionCluster> ClusterDirections(const PlaneSet& set) {
  std::vector<DirectionCluster> clusters;
  std::vector<Eigen::Vector3d> sums;
  for (const std::int32_t p : LargestPlanes(set)) {
    const PlaneSegment& plane = set.planes[p];
    std::size_t best = clusters.size();
    double cosine = kOneDirection;
    for (std::size_t k = 0; k < clusters.size(); ++k) {
      const double c = clusters[k].direction.dot(plane.plane.normal);
      if (c > cosine) cosine = c, best = k;
    }
    if (best == clusters.size()) {
      clusters.emplace_back();
      sums.emplace_back(Eigen::Vector3d::Zero());
    }
    sums[best] += plane.area * plane.plane.normal;
    clusters[best].direction = sums[best].normalized();
    clusters[best].weight += plane.area;
    clusters[best].planes.push_back(p);
  }
  for (auto& cluster : clusters) cluster.weight = std::sqrt(cluster.weight);
  std::stable_sort(clusters.begin(), clusters.end(),
                   [](const auto& a, const auto& b) { return a.weight > b.weight; });
  if (clusters.size() > kMostDirections) clusters.resize(kMostDirections);
  return clusters;
}

// Area of the surfels that lie along the same axis (either way), by a coarse histogram over six
// pairs of opposite directions and what lies between: the share of one surfel's kind.
std::vector<double> AxisAreas(const std::vector<Surfel>& surfels,
                              const std::vector<DirectionCluster>& directions,
                              std::vector<int>* axis) {
  std::vector<double> areas(directions.size() + 1, 0.0);
  axis->assign(surfels.size(), static_cast<int>(directions.size()));
  for (std::size_t i = 0; i < surfels.size(); ++i) {
    double cosine = 0.9;
    for (std::size_t k = 0; k < directions.size(); ++k) {
      const double c = std::abs(directions[k].direction.dot(surfels[i].normal));
      if (c > cosine) cosine = c, (*axis)[i] = static_cast<int>(k);
    }
    areas[(*axis)[i]] += surfels[i].area;
  }
  return areas;
}

}  // namespace

ScanModel::ScanModel(const PlaneSet& plane_set)
    : planes(&plane_set), map(MakeSurfels(plane_set)), directions(ClusterDirections(plane_set)) {
  const auto& surfels = map.surfels();
  std::vector<int> axis;
  const std::vector<double> areas = AxisAreas(surfels, directions, &axis);
  const double total = std::accumulate(areas.begin(), areas.end(), 0.0);
  double sum = 0.0;
  std::vector<double> cumulative(surfels.size());
  for (std::size_t i = 0; i < surfels.size(); ++i) {
    sum += surfels[i].area / (areas[axis[i]] + 0.05 * total);
    cumulative[i] = sum;
  }
  // Systematic sampling by weight: patches are in spatial order, so the samples spread evenly, and
  // each then counts the same.
  const std::size_t count = std::min(kSamples, surfels.size());
  for (std::size_t k = 0, i = 0; k < count; ++k) {
    while (i + 1 < surfels.size() && cumulative[i] < (k + 0.5) * sum / count) ++i;
    if (!samples.empty() && samples.back() == i) {
      sample_weights.back() += 1.0 / count;
    } else {
      samples.push_back(static_cast<std::uint32_t>(i));
      sample_weights.push_back(1.0 / count);
    }
  }
}

}  // namespace planegraph
