#include "paper/section.h"

#include <algorithm>
#include <functional>
#include <numeric>

#include "plane_subset.h"

namespace planegraph {
namespace {

double Reach(const PlaneSet& scan) {
  std::vector<double> reach;
  for (const PlaneSegment& plane : scan.planes) {
    for (const auto& corner : plane.hull) reach.push_back(corner.head<2>().norm());
  }
  if (reach.empty()) return 0.0;
  const auto high =
      reach.begin() + static_cast<std::ptrdiff_t>(0.9 * static_cast<double>(reach.size() - 1));
  std::nth_element(reach.begin(), high, reach.end());
  return *high;
}

bool Inside(const Eigen::Vector3d& point, const Eigen::Vector3d& place, double half_edge) {
  return (point - place).head<2>().cwiseAbs().maxCoeff() <= half_edge;
}

template <typename Items, typename Place>
std::size_t CountInside(const Items& items, const Place& place_of, const Eigen::Vector3d& place,
                        double half_edge) {
  return static_cast<std::size_t>(std::count_if(items.begin(), items.end(), [&](const auto& item) {
    return Inside(std::invoke(place_of, item), place, half_edge);
  }));
}

}  // namespace

Sim3 MetricFromScan(const MapResult& result, std::size_t map, std::size_t scan) {
  return result.solution.world_from_metric[map].Inverse() *
         Sim3(result.solution.world_from_scan[scan]);
}

Section SectionAbout(const MapResult& result, std::size_t m, std::size_t scan, const Cloud& cloud) {
  const MapRecord& map = result.maps[m];
  const Eigen::Vector3d place = MetricFromScan(result, m, scan).translation;
  Section section;
  section.half_edge = Reach(result.scans[scan].planes) + kSectionTolerance;
  const double half = section.half_edge;
  const auto of_point = [&](const Eigen::Vector3f& p) {
    return Eigen::Vector3d(cloud.offset + p.cast<double>());
  };
  section.points = CountInside(cloud.points, of_point, place, half);
  const auto of_patch = [](const Patch& p) { return p.moments.mean; };
  section.patches = CountInside(map.planes.patches, of_patch, place, half);
  const auto of_plane = [](const PlaneSegment& p) { return p.centroid(); };
  section.planes = CountInside(map.planes.planes, of_plane, place, half);
  section.seconds_segment = map.seconds_segment * static_cast<double>(section.points) /
                            static_cast<double>(std::max<std::size_t>(map.points, 1));
  return section;
}

PlaneSet PlanesAbout(const PlaneSet& map, const Eigen::Vector3d& place, double half_edge) {
  std::vector<std::size_t> kept;
  for (std::size_t k = 0; k < map.planes.size(); ++k) {
    if (Inside(map.planes[k].centroid(), place, half_edge)) kept.push_back(k);
  }
  return Subset(map, kept);
}

}  // namespace planegraph
