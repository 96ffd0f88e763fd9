#include "paper/runs.h"

#include <algorithm>

#include "planegraph/base/error.h"
#include "planegraph/io/trajectory_io.h"

namespace planegraph {
namespace {

void KeepLess(double other, double* seconds) { *seconds = std::min(*seconds, other); }

void KeepLeastTimes(const MapResult& other, MapResult* result) {
  for (std::size_t i = 0; i < result->scans.size(); ++i) {
    KeepLess(other.scans[i].seconds_preprocess, &result->scans[i].seconds_preprocess);
    KeepLess(other.scans[i].seconds_segment, &result->scans[i].seconds_segment);
  }
  for (std::size_t m = 0; m < result->maps.size(); ++m) {
    KeepLess(other.maps[m].seconds_segment, &result->maps[m].seconds_segment);
  }
  for (std::size_t k = 0; k < result->pairs.size(); ++k) {
    KeepLess(other.pairs[k].seconds, &result->pairs[k].seconds);
  }
  for (std::size_t k = 0; k < result->map_pairs.size(); ++k) {
    KeepLess(other.map_pairs[k].seconds, &result->map_pairs[k].seconds);
  }
}

Trajectory EstimateOf(const MapResult& result, std::size_t robot) {
  Trajectory trajectory;
  trajectory.has_times = false;
  for (std::size_t i = 0; i < result.scans.size(); ++i) {
    if (result.scans[i].robot != robot) continue;
    trajectory.times.push_back(static_cast<double>(result.scans[i].index));
    trajectory.poses.push_back(result.solution.world_from_scan[i]);
  }
  return trajectory;
}

// Alignment on the first pose where the positions do not define another one.
AteResult AlignedAte(const PosePairs& pairs) {
  try {
    return ComputeAte(pairs, PoseAlignment::kSe3);
  } catch (const NoResultError&) {
    return ComputeAte(pairs, PoseAlignment::kFirst);
  }
}

}  // namespace

MapResult MapTimed(const Site& site, const std::string& optimizer, int runs) {
  MapOptions options;
  options.optimizer = optimizer;
  options.threads = 1;
  MapResult result = MapScans(site, options);
  for (int k = 1; k < runs; ++k) KeepLeastTimes(MapScans(site, options), &result);
  return result;
}

Site LaserOnly(Site site) {
  site.maps.clear();
  for (RobotSite& robot : site.robots) robot.start.reset();
  return site;
}

std::optional<RobotErrors> ErrorsOf(const MapResult& result, std::size_t robot) {
  const std::string& reference = result.site.robots[robot].reference;
  const Trajectory estimate = EstimateOf(result, robot);
  if (reference.empty() || estimate.size() < 2) return {};
  const PosePairs pairs = PairPoses(ReadTrajectory(reference), estimate);
  return RobotErrors{AlignedAte(pairs), ComputeRpe(pairs, {})};
}

std::optional<Rigid3> ReferenceStep(const MapResult& result, std::size_t target,
                                    std::size_t source) {
  const std::string& reference = result.site.robots[result.scans[target].robot].reference;
  if (reference.empty()) return {};
  const Trajectory truth = ReadTrajectory(reference);
  return truth.poses.at(result.scans[target].index).Inverse() *
         truth.poses.at(result.scans[source].index);
}

}  // namespace planegraph
