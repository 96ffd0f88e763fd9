#include "planegraph/cloud/filters.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "planegraph/base/error.h"
#include "planegraph/base/parallel.h"
#include "planegraph/cloud/kd_tree.h"

namespace planegraph {
namespace {

template <typename Keep>
Cloud KeepIf(const Cloud& cloud, const Keep& keep) {
  std::vector<std::uint32_t> kept;
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    if (keep(i)) kept.push_back(static_cast<std::uint32_t>(i));
  }
  return Select(cloud, kept);
}

// Mean distance of every point to its k nearest neighbours, itself left out.
std::vector<double> MeanDistances(const Cloud& cloud, std::size_t k, int threads) {
  const KdTree tree(cloud.points);
  std::vector<double> means(cloud.size(), 0.0);
  constexpr std::size_t kBlock = 1024;
  ParallelFor((cloud.size() + kBlock - 1) / kBlock, threads, [&](std::size_t block) {
    std::vector<KdTree::Neighbour> near;
    const std::size_t end = std::min(cloud.size(), (block + 1) * kBlock);
    for (std::size_t i = block * kBlock; i < end; ++i) {
      tree.Nearest(cloud.points[i], k + 1, &near);
      for (const auto& n : near) means[i] += std::sqrt(static_cast<double>(n.squared_distance));
      if (near.size() > 1) means[i] /= static_cast<double>(near.size() - 1);
    }
  });
  return means;
}

}  // namespace

Cloud OutlierFilter(const Cloud& cloud, std::size_t k, double stddev, int threads) {
  if (cloud.size() < 2 || k == 0) return cloud;
  const std::vector<double> distances = MeanDistances(cloud, k, threads);
  double mean = 0.0, squares = 0.0;
  for (const double d : distances) mean += d;
  mean /= static_cast<double>(distances.size());
  for (const double d : distances) squares += (d - mean) * (d - mean);
  const double sigma = std::sqrt(squares / static_cast<double>(distances.size() - 1));
  return KeepIf(cloud, [&](std::size_t i) { return distances[i] <= mean + stddev * sigma; });
}

Cloud RangeFilter(const Cloud& cloud, double min, double max) {
  return KeepIf(cloud, [&](std::size_t i) {
    const double range = (cloud.Position(i) - cloud.viewpoint).norm();
    return range >= min && range <= max;
  });
}

Cloud IncidenceFilter(const Cloud& cloud, double max_deg) {
  if (cloud.normals.size() != cloud.size()) {
    throw UsageError("incidence: the cloud has no normals; put the filter `normals` before it");
  }
  const double least = std::cos(max_deg * std::numbers::pi / 180.0);
  return KeepIf(cloud, [&](std::size_t i) {
    const Eigen::Vector3d normal = cloud.normals[i].cast<double>();
    if (normal.isZero()) return true;
    const Eigen::Vector3d beam = cloud.Position(i) - cloud.viewpoint;
    return std::abs(normal.dot(beam)) >= least * beam.norm();
  });
}

}  // namespace planegraph
