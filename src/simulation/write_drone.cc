#include <algorithm>
#include <cstdio>
#include <nlohmann/json.hpp>

#include "planegraph/base/atomic_file.h"
#include "planegraph/io/camera_io.h"
#include "planegraph/io/cloud_io.h"
#include "planegraph/io/local_frame.h"
#include "planegraph/io/trajectory_io.h"
#include "planegraph/simulation/drone.h"

namespace planegraph {
namespace {

using Eigen::Vector3d;

template <typename... Values>
std::string Format(const char* format, Values... values) {
  char text[256];
  std::snprintf(text, sizeof(text), format, values...);
  return text;
}

void WriteMveCloud(const std::string& path, const PhotogrammetryModel& model) {
  const Cloud& cloud = model.cloud;
  std::string text =
      "ply\nformat binary_little_endian 1.0\nelement vertex " + std::to_string(cloud.size()) + "\n";
  for (const char* name : {"x", "y", "z", "nx", "ny", "nz"}) {
    text += std::string("property float ") + name + "\n";
  }
  text +=
      "property uchar red\nproperty uchar green\nproperty uchar blue\n"
      "property float confidence\nproperty float value\nend_header\n";
  const auto append = [&](const void* data, std::size_t bytes) {
    text.append(static_cast<const char*>(data), bytes);
  };
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    const float confidence = 1.0f / (1.0f + 10.0f * model.sigmas[i]);
    append(cloud.points[i].data(), 12);
    append(cloud.normals[i].data(), 12);
    append(cloud.colors[i].data(), 3);
    append(&confidence, 4);
    append(&model.spacings[i], 4);
  }
  WriteTextFile(path, text);
}

CameraModel CamerasOf(const PinholeCamera& camera, const PhotogrammetryModel& model) {
  CameraModel cameras;
  cameras.format = "mve";
  for (const auto& map_from_camera : model.map_from_camera) {
    Camera& one = cameras.cameras.emplace_back();
    if (!map_from_camera) continue;
    one.valid = true;
    one.camera_from_model = map_from_camera->Inverse();
    one.focal = camera.focal;
  }
  return cameras;
}

std::string ImageTimesText(const Flight& flight) {
  std::string text = "time,file\n";
  for (std::size_t k = 0; k < flight.times.size(); ++k) {
    text += Format("%.3f,img_%04zu.jpg\n", flight.times[k], k);
  }
  return text;
}

nlohmann::json AsJson(const Vector3d& v) { return {v.x(), v.y(), v.z()}; }

std::string SimilarityText(const SimulatedDrone& drone) {
  const Sim3& world_from_map = drone.model.world_from_map;
  const Eigen::Matrix3d r = world_from_map.rotation.toRotationMatrix();
  nlohmann::json rows = nlohmann::json::array();
  for (int row = 0; row < 3; ++row) rows.push_back(AsJson(r.row(row).transpose()));
  const auto& cameras = drone.model.map_from_camera;
  const auto used = std::count_if(cameras.begin(), cameras.end(),
                                  [](const auto& camera) { return camera.has_value(); });
  const nlohmann::json json = {{"convention", "p_world = scale * R * p_map + t"},
                               {"scale", world_from_map.scale},
                               {"R", rows},
                               {"t", AsJson(world_from_map.translation)},
                               {"cameras_used", used},
                               {"cameras_total", cameras.size()},
                               {"gps", {{"bias_enu", AsJson(drone.gps.bias)}}}};
  return json.dump(1) + "\n";
}

}  // namespace

std::string GpsText(const SimulatedGps& track, const GeodeticPosition& origin) {
  const LocalFrame frame(origin);
  std::string text = "time,lat,lon,alt\n";
  for (std::size_t k = 0; k < track.times.size(); ++k) {
    const GeodeticPosition at = frame.ToGeodetic(track.positions[k]);
    text += Format("%.3f,%.9f,%.9f,%.3f\n", track.times[k], at.latitude, at.longitude, at.altitude);
  }
  return text;
}

void WriteDrone(const std::string& folder, const SimulatedDrone& drone) {
  const std::string uav = folder + "/uav", truth = folder + "/truth";
  CreateFolder(uav);
  CreateFolder(truth + "/labels");
  const PhotogrammetryModel& model = drone.model;
  WriteMveCloud(uav + "/cloud.ply", model);
  WriteMveCameras(uav + "/synth_0.out", CamerasOf(drone.flight.camera, model));
  WriteTextFile(uav + "/images.csv", ImageTimesText(drone.flight));
  WriteTextFile(uav + "/gps.csv", GpsText(drone.gps, drone.origin));
  WriteTextFile(truth + "/similarity.json", SimilarityText(drone));
  WriteTum(truth + "/uav_cameras.tum", {drone.flight.times, drone.flight.world_from_camera});
  Cloud bare;
  bare.points = model.cloud.points;
  WriteCloud(truth + "/labels/uav_cloud.ply", bare,
             {{"plane", std::vector<std::int32_t>(model.labels.begin(), model.labels.end())},
              {"view", model.views}});
}

}  // namespace planegraph
