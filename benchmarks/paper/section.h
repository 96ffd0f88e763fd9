#pragma once

#include "planegraph/cloud/cloud.h"
#include "planegraph/pipeline/mapper.h"

namespace planegraph {

/// What a drone map has about a scan: a square as large as the scan by its planes (nine tenths of
/// their corners) and a tolerance on each side, as the paper cuts its sections.
struct Section {
  double half_edge = 0.0;  ///< metres
  std::size_t points = 0, patches = 0, planes = 0;
  double seconds_segment = 0.0;  ///< the points' share of the whole map's segmentation
};

inline constexpr double kSectionTolerance = 5.0;  ///< metres

/// `cloud`: the map's, in its metric frame.
Section SectionAbout(const MapResult& result, std::size_t map, std::size_t scan,
                     const Cloud& cloud);

/// The planes of the map with their centroid within `half_edge` of the place, in x and y.
PlaneSet PlanesAbout(const PlaneSet& map, const Eigen::Vector3d& place, double half_edge);

/// The scan in the map's metric frame by the solution.
Sim3 MetricFromScan(const MapResult& result, std::size_t map, std::size_t scan);

}  // namespace planegraph
