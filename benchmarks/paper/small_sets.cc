#include "paper/small_sets.h"

#include <algorithm>
#include <cstdio>

#include "paper/section.h"
#include "plane_subset.h"
#include "planegraph/base/angles.h"
#include "planegraph/geometry/rotation.h"
#include "planegraph/registration/map_registration.h"
#include "planegraph/registration/xiao.h"
#include "thread_seconds.h"

namespace planegraph {
namespace {

constexpr std::size_t kScanPlanes = 30, kMapPlanes = 150;
constexpr double kReach = 35.0;  // metres: of the scanner
constexpr double kStartMetres = 1.0, kStartRadians = 10.0 * kDegree;

// As a scan is registered to a map once its group is placed.
MapEvidence RegisterHere(const MapModel& map, const ScanGroup& group, const Sim3& start,
                         MapRefinement* refinement) {
  MapRefinementOptions options;
  options.first_gate = 0.3;
  options.sigma_scale = 0.0;
  *refinement = RefineInMap(map, group, start, options);
  const double gate = std::max(0.1, 5.0 * map.planes().noise.constant);
  return MeasureEvidence(map, group, refinement->map_from_group, gate);
}

// A start that is off as far as its standard deviations say: each axis and the heading by one.
Rigid3 RoughStart(const Sim3& pose) {
  const Eigen::AngleAxisd turn(kStartRadians, Eigen::Vector3d::UnitZ());
  return {turn * pose.rotation, pose.translation + kStartMetres * Eigen::Vector3d(1.0, -1.0, 1.0)};
}

MapLocation LocateFrom(const MapModel& map, const ScanGroup& group, const Rigid3& start) {
  MapLocationOptions options;
  options.prior.pose = MapPrior::Pose{start, kStartMetres, kStartRadians};
  options.prior.upright = true;
  return LocateInMap(map, group, options);
}

void PrintLocation(const MapLocation& location, const Sim3& truth) {
  if (location.candidates.empty()) return std::printf(" %s |", ToString(location.status)), void();
  const Sim3& found = location.candidates.front().refinement.map_from_group;
  std::printf(" %s, %.2f m %.1f deg |", ToString(location.status),
              (found.translation - truth.translation).norm(),
              AngleBetween(found.rotation, truth.rotation) / kDegree);
}

void PrintScan(const MapResult& result, std::size_t m, std::size_t scan) {
  const Sim3 pose = MetricFromScan(result, m, scan);
  const PlaneSet laser = LargestPlanes(result.scans[scan].planes, kScanPlanes);
  const PlaneSet section = LargestPlanes(
      PlanesAbout(result.maps[m].planes, pose.translation, kReach + kSectionTolerance), kMapPlanes);
  if (section.planes.empty()) return;
  const ScanModel model(laser);
  const MapModel map(section);
  const ScanGroup group(model);
  MapRefinement refinement;
  MapLocation location;
  const double build = LeastSeconds(3, [&] { ScanModel a(laser), b(section); });
  const double here = LeastSeconds(10, [&] { RegisterHere(map, group, pose, &refinement); });
  const Rigid3 start = RoughStart(pose);
  const double locate = LeastSeconds(10, [&] { location = LocateFrom(map, group, start); });
  XiaoMatch xiao;
  const double search = LeastSeconds(1, [&] { xiao = MatchXiao(section, laser, {}); });
  std::printf("| %s | %zu | %zu | %.1f | %.1f | %.1f |", result.scans[scan].id.c_str(),
              laser.planes.size(), section.planes.size(), 1e3 * build, 1e3 * here, 1e3 * locate);
  PrintLocation(location, pose);
  std::printf(" %.1f%s |\n", 1e3 * search, xiao.capped ? " (stopped at its limit)" : "");
  std::fflush(stdout);
}

}  // namespace

void PrintSmallSets(const MapResult& result) {
  std::printf(
      "\n## Registration of %zu laser planes with %zu map planes, milliseconds of CPU time on one "
      "thread\n\n"
      "The largest planes of the scan and of the map's section about it. `here`: refinement from "
      "the "
      "scan's place and\nthe evidence, as each placed scan is registered to its section. `from a "
      "start`: the whole search (votes, first look, refinement of 40\nposes, evidence) from a "
      "start "
      "that is off by its standard deviations of 1 m on each axis and 10 deg, compared with the "
      "solution.\n`models`: surfels and directions of both, once for each set. `Xiao`: the paper's "
      "search over the same planes.\n\n"
      "| scan | laser planes | map planes | models | here | from a start | found | Xiao |\n"
      "|---|---|---|---|---|---|---|---|\n",
      kScanPlanes, kMapPlanes);
  for (const MapPairRecord& pair : result.map_pairs) {
    if (pair.used) PrintScan(result, pair.map, pair.scan);
  }
}

}  // namespace planegraph
