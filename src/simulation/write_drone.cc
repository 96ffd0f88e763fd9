#include <GeographicLib/LocalCartesian.hpp>
#include <algorithm>
#include <cstdio>
#include <nlohmann/json.hpp>

#include "planegraph/base/atomic_file.h"
#include "planegraph/io/cloud_io.h"
#include "planegraph/io/trajectory_io.h"
#include "planegraph/simulation/drone.h"

namespace planegraph {
namespace {

using Eigen::Vector3d;

// Latitude and longitude (degrees) and altitude of a point of the world, which is east-north-up.
Vector3d ToGeodetic(const GeodeticOrigin& origin, const Vector3d& x_in_world) {
  const GeographicLib::LocalCartesian frame(origin.latitude, origin.longitude, origin.altitude);
  Vector3d geodetic;
  frame.Reverse(x_in_world.x(), x_in_world.y(), x_in_world.z(), geodetic.x(), geodetic.y(),
                geodetic.z());
  return geodetic;
}

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

// Per camera: focal length and distortion, three rows of R, t, with x_camera = R x_map + t.
std::string BundleText(const PinholeCamera& camera, const PhotogrammetryModel& model) {
  std::string text = Format("drews 1.0\n%zu 0\n", model.map_from_camera.size());
  for (const auto& map_from_camera : model.map_from_camera) {
    if (!map_from_camera) {
      text += "0 0 0\n0 0 0\n0 0 0\n0 0 0\n0 0 0\n";
      continue;
    }
    const Rigid3 camera_from_map = map_from_camera->Inverse();
    const Eigen::Matrix3d r = camera_from_map.rotation.toRotationMatrix();
    const Vector3d& t = camera_from_map.translation;
    text += Format("%.9g 0 0\n", camera.focal);
    for (int row = 0; row < 3; ++row) {
      text += Format("%.12g %.12g %.12g\n", r(row, 0), r(row, 1), r(row, 2));
    }
    text += Format("%.12g %.12g %.12g\n", t.x(), t.y(), t.z());
  }
  return text;
}

std::string ImageTimes(const Flight& flight) {
  std::string text = "time,file\n";
  for (std::size_t k = 0; k < flight.times.size(); ++k) {
    text += Format("%.3f,img_%04zu.jpg\n", flight.times[k], k);
  }
  return text;
}

std::string GpsText(const GpsTrack& track, const GeodeticOrigin& origin) {
  std::string text = "time,lat,lon,alt\n";
  for (std::size_t k = 0; k < track.times.size(); ++k) {
    const Vector3d geodetic = ToGeodetic(origin, track.positions[k]);
    text +=
        Format("%.3f,%.9f,%.9f,%.3f\n", track.times[k], geodetic.x(), geodetic.y(), geodetic.z());
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

void WriteDrone(const std::string& folder, const SimulatedDrone& drone) {
  const std::string uav = folder + "/uav", truth = folder + "/truth";
  CreateFolder(uav);
  CreateFolder(truth + "/labels");
  const PhotogrammetryModel& model = drone.model;
  WriteMveCloud(uav + "/cloud.ply", model);
  WriteTextFile(uav + "/synth_0.out", BundleText(drone.flight.camera, model));
  WriteTextFile(uav + "/images.csv", ImageTimes(drone.flight));
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
