#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "planegraph/pipeline/site.h"
#include "planegraph/registration/georeference.h"
#include "planegraph/segmentation/map_segmenter.h"

namespace planegraph {

class TileFile;

/// What a drone map's points may take.
struct MapMemory {
  std::uint64_t bytes = 1000000000;
  /// A folder on a disk with room for the points of a cloud that needs more than that.
  std::string scratch = std::filesystem::temp_directory_path().string();
};

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
  /// Of a cloud that memory is too small for: its points, in the metric frame, and their labels in
  /// place of those above.
  std::shared_ptr<TileFile> tiles;
  double sigma_scale = 0.02;  ///< of log(scale) of the metric frame before any laser is seen
  std::size_t points = 0;
  double seconds_read = 0, seconds_segment = 0;

  bool has_position() const { return georeference && georeference->status == "ok"; }
};

/// Scale and place by GPS (step d of the paper), reading and segmentation of a drone map. The map
/// is segmented once, as a whole; a section is a query (steps e to g). A georeference that fails
/// leaves the map unscaled and says so in *warnings. A cloud that would take more than `memory` is
/// read in parts and segmented from tiles on disk, with the same result; but where its tiles are
/// too full for the memory as well, they are cut smaller, and planes end at their borders. Throws
/// InputError, UsageError.
MapRecord PrepareMap(const Site& site, std::size_t index, int threads,
                     std::vector<std::string>* warnings, const MapMemory& memory = {});

/// The map's cloud in another frame, offset included; normals turned along.
Cloud LoadMapCloud(const DroneMapSite& map, const Sim3& target_from_map);

}  // namespace planegraph
