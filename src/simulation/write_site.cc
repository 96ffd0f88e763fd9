#include <cmath>
#include <cstdio>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "planegraph/base/angles.h"
#include "planegraph/base/atomic_file.h"
#include "planegraph/io/cloud_io.h"
#include "planegraph/io/trajectory_io.h"
#include "planegraph/simulation/simulation.h"

namespace planegraph {
namespace {

std::string ScanName(std::size_t k) {
  char name[32];
  std::snprintf(name, sizeof(name), "scan%03zu.ply", k);
  return name;
}

// Scans beyond the last one would otherwise match the site's glob.
void RemoveLeftOvers(const std::string& folder, std::size_t count) {
  std::error_code ignored;
  for (std::size_t k = count; std::filesystem::remove(folder + "/" + ScanName(k), ignored);) ++k;
}

void WriteScans(const std::string& clouds, const std::string& labels,
                const std::vector<LabelledScan>& scans) {
  CreateFolder(clouds);
  CreateFolder(labels);
  for (std::size_t k = 0; k < scans.size(); ++k) {
    const auto& [cloud, of_points] = scans[k];
    WriteCloud(clouds + "/" + ScanName(k), cloud);
    WriteCloud(labels + "/" + ScanName(k), cloud,
               {{"plane", std::vector<std::int32_t>(of_points.begin(), of_points.end())}});
  }
  RemoveLeftOvers(clouds, scans.size());
  RemoveLeftOvers(labels, scans.size());
}

std::string PlanesAsJson(const std::vector<Plane>& planes) {
  nlohmann::json list = nlohmann::json::array();
  for (std::size_t i = 0; i < planes.size(); ++i) {
    const Eigen::Vector3d& n = planes[i].normal;
    list.push_back(
        {{"id", i}, {"normal", {n.x(), n.y(), n.z()}}, {"distance", planes[i].distance}});
  }
  return nlohmann::json{{"planes", list}}.dump(1) + "\n";
}

// A single robot needs no folder of its own.
std::string RobotFolder(const SimulatedSite& site, const SimulatedRobot& robot) {
  return site.robots.size() > 1 ? robot.name + "/" : "";
}

std::string StartText(const Rigid3& start) {
  char text[256];
  std::snprintf(text, sizeof(text),
                "    start: {translation: [%.3f, %.3f, %.3f], rotation: [0, 0, %.5f, %.5f], "
                "sigma_translation: 1.0, sigma_rotation_deg: 10}\n",
                start.translation.x(), start.translation.y(), start.translation.z(),
                start.rotation.z(), start.rotation.w());
  return text;
}

// What a site file says beside the scans.
struct Given {
  bool drone = false, start = false, gps = false;
};

std::string GpsKeys(const std::string& folder) {
  char text[256];
  std::snprintf(text, sizeof(text), "    gps: %sgps.csv\n    gps_lever: [%.1f, %.1f, %.1f]\n",
                folder.c_str(), kAntenna.x(), kAntenna.y(), kAntenna.z());
  return text;
}

// What SimulateOdometry errs by, in the terms of a site file. Lengths are off by one factor of a
// run, uniform between its limits and of either sign; yaw errs most of all turns.
std::string NoiseText(const OdometryOptions& o) {
  const double scale = std::sqrt(
      (o.scale_min * o.scale_min + o.scale_min * o.scale_max + o.scale_max * o.scale_max) / 3.0);
  char text[200];
  std::snprintf(text, sizeof(text),
                "    odometry_noise: {step: %.3f, per_metre: %.4f, scale: %.4f, step_deg: %.2f, "
                "per_turn: %.3f, per_metre_deg: %.2f}\n",
                o.step_sigma, o.forward_sigma, scale, o.tilt_sigma / kDegree, o.turn_sigma,
                (o.yaw_sigma + o.yaw_drift_max) / kDegree);
  return text;
}

std::string RobotText(const SimulatedRobot& robot, const std::string& folder, const Given& given) {
  return "  - name: " + robot.name + "\n    scans: " + folder +
         "scans/scan*.ply\n    odometry: " + folder + "odometry.tum\n" +
         NoiseText(robot.odometry_options) +
         (given.start && robot.start ? StartText(*robot.start) : "") +
         (given.gps ? GpsKeys(folder) : "") + "    reference: " + folder +
         "truth.tum   # for evaluation alone\n";
}

std::string OriginText(const GeodeticPosition& origin) {
  char text[128];
  std::snprintf(text, sizeof(text), "origin: {lat: %.9f, lon: %.9f, alt: %.3f}\n", origin.latitude,
                origin.longitude, origin.altitude);
  return text;
}

std::string SiteFile(const SimulatedSite& site, const Given& given) {
  std::string text = "name: " + site.name + "\n";
  if (given.drone) text += OriginText(site.drone->origin);
  text += "robots:\n";
  for (const SimulatedRobot& robot : site.robots) {
    text += RobotText(robot, RobotFolder(site, robot), given);
  }
  if (!given.drone) return text;
  return text +
         "maps:\n"
         "  - name: uav1\n"
         "    cloud: uav/cloud.ply\n"
         "    cameras: uav/synth_0.out\n"
         "    gps: uav/gps.csv\n"
         "    image_times: uav/images.csv\n"
         "    reference: truth/similarity.json   # for evaluation alone\n";
}

void WriteSiteFiles(const std::string& folder, const SimulatedSite& site) {
  const bool drone = site.drone.has_value();
  WriteTextFile(folder + "/site.yaml", SiteFile(site, {.drone = drone, .start = true}));
  const std::pair<const char*, Given> others[] = {
      {"/site_nostart.yaml", {.drone = true}},
      {"/site_gps.yaml", {.drone = true, .gps = true}},
      {"/site_laser_only.yaml", {}},
  };
  for (const auto& [name, given] : others) {
    std::error_code ignored;
    std::filesystem::remove(folder + name, ignored);
    if (drone) WriteTextFile(folder + name, SiteFile(site, given));
  }
}

}  // namespace

void WriteSite(const std::string& folder, const SimulatedSite& site) {
  for (const SimulatedRobot& robot : site.robots) {
    const std::string own = RobotFolder(site, robot);
    WriteScans(folder + "/" + own + "scans", folder + "/truth/labels/" + own, robot.scans);
    WriteTum(folder + "/" + own + "odometry.tum", {robot.times, robot.odometry});
    WriteTum(folder + "/" + own + "truth.tum", {robot.times, robot.truth});
    if (site.drone) {
      WriteTextFile(folder + "/" + own + "gps.csv", GpsText(robot.gps, site.drone->origin));
    }
  }
  WriteTextFile(folder + "/truth/planes.json", PlanesAsJson(site.planes));
  if (site.drone) WriteDrone(folder, *site.drone);
  WriteSiteFiles(folder, site);
}

}  // namespace planegraph
