#pragma once

#include <optional>
#include <string>
#include <vector>

#include "planegraph/pipeline/site.h"
#include "planegraph/registration/georeference.h"
#include "planegraph/segmentation/map_segmenter.h"

namespace planegraph {

/// One drone map after the front end: its planes, not its points.
struct MapRecord {
  std::string id;
  std::optional<Georeference> georeference;  ///< by GPS or metric positions; absent: none given
  /// The frame that the planes are in: metres and east-north-up as far as GPS tells, less a shift
  /// that keeps the numbers small. Without GPS the map's own.
  Sim3 metric_from_map;
  Sim3 world_from_metric;            ///< by GPS alone (a shift); identity without
  PlaneSet planes;                   ///< in the metric frame
  std::vector<std::int32_t> labels;  ///< per point of the cloud the plane's index, -1: none
  double sigma_scale = 0.02;         ///< of log(scale) of the metric frame before any laser is seen
  std::size_t points = 0;
  double seconds_read = 0, seconds_segment = 0;

  bool has_position() const { return georeference && georeference->status == "ok"; }
};

/// Scale and place by GPS (step d of the paper), reading and segmentation of a drone map. The map
/// is segmented once, as a whole; a section is a query (steps e to g). A georeference that fails
/// leaves the map unscaled and says so in *warnings. Throws InputError, UsageError.
MapRecord PrepareMap(const Site& site, std::size_t index, int threads,
                     std::vector<std::string>* warnings);

/// The map's cloud in another frame, offset included; normals turned along.
Cloud LoadMapCloud(const DroneMapSite& map, const Sim3& target_from_map);

}  // namespace planegraph
