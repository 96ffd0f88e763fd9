#include "planegraph/pipeline/map_front_end.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <stdexcept>

#include "planegraph/base/error.h"
#include "planegraph/io/cloud_io.h"

namespace planegraph {
namespace {

double Seconds(std::chrono::steady_clock::time_point start) {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

std::optional<Georeference> GeoreferenceMap(const Site& site, const DroneMapSite& map) {
  if (map.gps.empty() || map.cameras.empty()) return {};
  std::optional<ImageTimes> times;
  if (!map.image_times.empty()) times = ReadImageTimes(map.image_times);
  GeoreferenceOptions options;
  options.origin = site.origin;
  return ComputeGeoreference(ReadCameras(map.cameras), ReadGps(map.gps), times, options);
}

// The middle of the cameras in whole metres: what keeps coordinates small.
Eigen::Vector3d MiddleOf(const Georeference& georeference) {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (const CameraFix& fix : georeference.fixes) sum += fix.position_in_world;
  return (sum / static_cast<double>(georeference.fixes.size())).array().round();
}

// Positions that the user trusts less, or more, than their residuals say.
void SetGpsSigma(double sigma, Georeference* georeference) {
  const double factor = sigma / std::max(georeference->sigma_horizontal, 1e-9);
  georeference->sigma_horizontal *= factor;
  georeference->sigma_vertical *= factor;
  georeference->sigma_scale *= factor;
  georeference->covariance *= factor * factor;
}

// Clouds without normals: each surface faces most of the cameras, the nearer ones above all. Where
// they stand on both sides its orientation stays unknown.
void OrientByCameras(const std::string& file, const Sim3& metric_from_map, PlaneSet* planes) {
  constexpr double kMajority = 0.5;
  std::vector<Eigen::Vector3d> centres;
  for (const Camera& camera : ReadCameras(file).cameras) {
    if (camera.valid) centres.push_back(metric_from_map * camera.Centre());
  }
  for (Patch& patch : planes->patches) {
    double facing = 0.0, total = 0.0;
    for (const Eigen::Vector3d& centre : centres) {
      const Eigen::Vector3d to_camera = centre - patch.moments.mean;
      const double weight = std::abs(patch.normal.dot(to_camera)) / std::pow(to_camera.norm(), 3);
      facing += patch.normal.dot(to_camera) > 0.0 ? weight : -weight;
      total += weight;
    }
    if (std::abs(facing) < kMajority * total || total == 0.0) continue;
    if (facing < 0.0) patch.normal = -patch.normal;
    patch.orientation = Orientation::kSensor;
  }
}

// A point far off everything is the file's error, not the program's.
Segmentation Segment(const Cloud& cloud, const std::string& file,
                     const MapSegmentationOptions& options) {
  try {
    return SegmentMap(cloud, options);
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
  if (!map->has_position()) map->metric_from_map.scale = site.scale;
  if (site.scale_sigma) map->sigma_scale = *site.scale_sigma;
}

}  // namespace

Cloud LoadMapCloud(const DroneMapSite& map, const Sim3& target_from_map) {
  Cloud cloud = ReadCloud(map.cloud);
  const Eigen::Vector3d offset = (target_from_map * cloud.offset).array().round();
  const Sim3 moved(target_from_map.scale, target_from_map.rotation,
                   target_from_map * cloud.offset - offset);
  const Eigen::Matrix3d turn = moved.scale * moved.rotation.toRotationMatrix();
  for (auto& point : cloud.points) {
    point = (turn * point.cast<double>() + moved.translation).cast<float>();
  }
  const Eigen::Matrix3f rotation = moved.rotation.toRotationMatrix().cast<float>();
  for (auto& normal : cloud.normals) normal = (rotation * normal).eval();
  cloud.viewpoint = target_from_map * cloud.viewpoint;
  cloud.offset = offset;
  return cloud;
}

MapRecord PrepareMap(const Site& site, std::size_t index, int threads,
                     std::vector<std::string>* warnings) {
  const DroneMapSite& source = site.maps[index];
  MapRecord map;
  map.id = source.name;
  map.georeference = GeoreferenceMap(site, source);
  if (map.georeference && !map.has_position()) {
    warnings->push_back(map.id + ": no scale and place by GPS: " + map.georeference->reason);
  }
  SetFrames(source, &map);
  auto start = std::chrono::steady_clock::now();
  Cloud cloud = LoadMapCloud(source, map.metric_from_map);
  // The planes leave an offset out: it becomes part of the metric frame.
  const Sim3 shift(1.0, Eigen::Quaterniond::Identity(), cloud.offset);
  map.metric_from_map = shift.Inverse() * map.metric_from_map;
  map.world_from_metric = map.world_from_metric * shift;
  cloud.viewpoint -= cloud.offset;
  cloud.offset.setZero();
  map.points = cloud.size();
  map.seconds_read = Seconds(start);
  start = std::chrono::steady_clock::now();
  MapSegmentationOptions options;
  options.segmentation = VisionOptions(cloud);
  options.threads = threads;
  Segmentation segmentation = Segment(cloud, source.cloud, options);
  map.planes = std::move(segmentation.planes);
  if (cloud.normals.empty() && !source.cameras.empty()) {
    OrientByCameras(source.cameras, map.metric_from_map, &map.planes);
  }
  map.labels = std::move(segmentation.labels);
  map.seconds_segment = Seconds(start);
  return map;
}

}  // namespace planegraph
