#include "planegraph/pipeline/map_front_end.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <filesystem>
#include <stdexcept>

#include "pipeline/camera_sides.h"
#include "pipeline/lap.h"
#include "pipeline/map_tiles.h"
#include "pipeline/model_frame.h"
#include "planegraph/base/error.h"
#include "planegraph/io/cloud_io.h"

namespace planegraph {
namespace {

std::optional<Georeference> GeoreferenceMap(const Site& site, const DroneMapSite& map) {
  if (map.gps.empty() || map.cameras.empty()) return {};
  std::optional<ImageTimes> times;
  if (!map.image_times.empty()) times = ReadImageTimes(map.image_times);
  GeoreferenceOptions options;
  options.origin = site.origin;
  return ComputeGeoreference(ReadCameras(map.cameras), ReadGps(map.gps), times, options);
}

// What is taken for granted where nothing says how large the map is and where.
std::optional<std::string> AssumptionOf(const DroneMapSite& map) {
  if (!map.gps.empty() && map.cameras.empty()) {
    return map.name + ": its GPS is not used, since no `cameras` say where the images were taken";
  }
  if (!map.gps.empty() && map.scale) {
    return map.name + ": its `scale` is not used: `gps` tells it";
  }
  if (!map.gps.empty() || map.scale || map.scale_sigma) return {};
  return map.name +
         ": no GPS: its unit is taken for the metre, and its place is searched for; "
         "`cameras` with `gps` tell both, `scale` (--map_scale) the unit";
}

// The middle of the cameras in whole metres: what keeps coordinates small.
Eigen::Vector3d MiddleOf(const Georeference& georeference) {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (const CameraFix& fix : georeference.fixes) sum += fix.position_in_world;
  return (sum / static_cast<double>(georeference.fixes.size())).array().round();
}

// Nobody's origin is that far from the site.
std::optional<std::string> OriginWarning(const Site& site, const Georeference& georeference) {
  constexpr double kFar = 50e3;  // metres
  if (!site.origin || georeference.fixes.empty()) return {};
  const double distance = MiddleOf(georeference).norm();
  if (distance < kFar) return {};
  return "`origin` lies " + std::to_string(static_cast<long>(distance / 1000.0)) +
         " km from the GPS positions: are latitude and longitude exchanged in one of them?";
}

// Positions that the user trusts less, or more, than their residuals say.
void SetGpsSigma(double sigma, Georeference* georeference) {
  const double factor = sigma / std::max(georeference->sigma_horizontal, 1e-9);
  georeference->sigma_horizontal *= factor;
  georeference->sigma_vertical *= factor;
  georeference->sigma_scale *= factor;
  georeference->covariance *= factor * factor;
}

std::vector<Eigen::Vector3d> CameraCentres(const std::string& file, const Sim3& metric_from_map) {
  std::vector<Eigen::Vector3d> centres;
  for (const Camera& camera : ReadCameras(file).cameras) {
    if (camera.valid) centres.push_back(metric_from_map * camera.Centre());
  }
  return centres;
}

// A point far off everything is the file's error, not the program's.
template <typename Segmenter>
void Segment(const std::string& file, const Segmenter& segmenter) {
  try {
    segmenter();
  } catch (const std::length_error& error) {
    throw InputError::InFile(file, error.what());
  }
}

void SetFrames(const DroneMapSite& site, MapRecord* map) {
  if (map->has_position() && site.gps_sigma) SetGpsSigma(*site.gps_sigma, &*map->georeference);
  if (map->has_position()) {
    const Eigen::Vector3d shift = MiddleOf(*map->georeference);
    map->world_from_metric = Sim3(1.0, Eigen::Quaterniond::Identity(), shift);
    map->metric_from_map = map->world_from_metric.Inverse() * map->georeference->world_from_map;
    map->sigma_scale = map->georeference->sigma_scale;
  }
  if (!map->has_position()) map->metric_from_map.scale = site.scale.value_or(1.0);
  if (site.scale_sigma) map->sigma_scale = *site.scale_sigma;
}

// The planes leave an offset out: it becomes part of the metric frame.
void TakeOffsetIn(const Eigen::Vector3d& offset, MapRecord* map) {
  const Sim3 shift(1.0, Eigen::Quaterniond::Identity(), offset);
  map->metric_from_map = shift.Inverse() * map->metric_from_map;
  map->world_from_metric = map->world_from_metric * shift;
}

// Reads and segments the cloud as a whole; whether it has normals.
bool SegmentWhole(const DroneMapSite& source, int threads, MapRecord* map) {
  auto start = std::chrono::steady_clock::now();
  Cloud cloud = LoadMapCloud(source, map->metric_from_map);
  TakeOffsetIn(cloud.offset, map);
  cloud.viewpoint -= cloud.offset;
  cloud.offset.setZero();
  map->points = cloud.size();
  map->seconds_read = SecondsSince(start);
  start = std::chrono::steady_clock::now();
  MapSegmentationOptions options;
  options.segmentation = VisionOptions(cloud);
  options.threads = threads;
  Segment(source.cloud, [&] {
    Segmentation segmentation = SegmentMap(cloud, options);
    map->planes = std::move(segmentation.planes);
    map->labels = std::move(segmentation.labels);
  });
  map->seconds_segment = SecondsSince(start);
  return !cloud.normals.empty();
}

// The same by way of tiles on disk.
bool SegmentInTiles(const DroneMapSite& source, int threads, const MapMemory& memory,
                    std::vector<std::string>* warnings, MapRecord* map) {
  auto start = std::chrono::steady_clock::now();
  const TiledCloud tiled = SpillCloud(source.cloud, map->metric_from_map, memory, threads);
  if (tiled.bytes_of_too_full) {
    warnings->push_back(source.name +
                        ": its fullest tiles of 3.2 m go beyond the memory that maps "
                        "may take, which would have to be " +
                        std::to_string(1 + *tiled.bytes_of_too_full / 1000000) + " MB");
  }
  TakeOffsetIn(tiled.shift, map);
  map->tiles = tiled.tiles;
  map->points = tiled.tiles->Points();
  map->seconds_read = SecondsSince(start);
  start = std::chrono::steady_clock::now();
  MapSegmentationOptions options;
  options.segmentation = VisionOptions(tiled.density);
  options.threads = tiled.threads;
  Segment(source.cloud, [&] {
    map->planes = SegmentTiles(*tiled.tiles, options,
                               [&](std::size_t tile, const std::vector<std::int32_t>& labels) {
                                 map->tiles->WriteLabels(tile, labels);
                               });
  });
  map->seconds_segment = SecondsSince(start);
  return tiled.tiles->has_normals();
}

// Whether the cloud has to be read in parts. Where that cannot be, it is read as a whole.
bool IsTooLarge(const DroneMapSite& source, const MapMemory& memory,
                std::vector<std::string>* warnings) {
  const auto bytes = BytesAsAWhole(source.cloud);
  if (bytes) return *bytes > memory.bytes;
  std::error_code error;
  const std::uintmax_t size = std::filesystem::file_size(source.cloud, error);
  if (!error && size > memory.bytes) {
    warnings->push_back(source.name +
                        ": its cloud is read as a whole, beyond the memory that maps may take: "
                        "only PLY and PCD without compression and lists, and with a header of less "
                        "than 1 MB, are read in parts");
  }
  return false;
}

}  // namespace

Cloud LoadMapCloud(const DroneMapSite& map, const Sim3& target_from_map) {
  Cloud cloud = ReadCloud(map.cloud);
  MoveCloud(target_from_map, &cloud);
  return cloud;
}

MapRecord PrepareMap(const Site& site, std::size_t index, int threads,
                     std::vector<std::string>* warnings, const MapMemory& memory) {
  const DroneMapSite& source = site.maps[index];
  MapRecord map;
  map.id = source.name;
  map.georeference = GeoreferenceMap(site, source);
  if (map.georeference && !map.has_position()) {
    warnings->push_back(map.id + ": no scale and place by GPS: " + map.georeference->reason);
  }
  if (const auto assumption = AssumptionOf(source)) warnings->push_back(*assumption);
  if (map.has_position()) {
    if (const auto far = OriginWarning(site, *map.georeference)) warnings->push_back(*far);
  }
  SetFrames(source, &map);
  const bool has_normals = IsTooLarge(source, memory, warnings)
                               ? SegmentInTiles(source, threads, memory, warnings, &map)
                               : SegmentWhole(source, threads, &map);
  const auto start = std::chrono::steady_clock::now();
  if (!has_normals && !source.cameras.empty()) {
    OrientByCameras(CameraCentres(source.cameras, map.metric_from_map), threads, &map.planes);
  }
  if (const auto warning = ModelFrameWarning(source, map)) warnings->push_back(*warning);
  map.seconds_segment += SecondsSince(start);
  return map;
}

}  // namespace planegraph
