#include <cstdio>
#include <filesystem>
#include <nlohmann/json.hpp>

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

void WriteScans(const std::string& folder, const std::vector<LabelledScan>& scans) {
  const std::string clouds = folder + "/scans", labels = folder + "/truth/labels";
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

std::string SiteFile(const std::string& name) {
  return "name: " + name +
         "\n"
         "robots:\n"
         "  - name: robot1\n"
         "    scans: scans/scan*.ply\n"
         "    odometry: odometry.tum\n"
         "    reference: truth.tum   # for evaluation alone\n";
}

}  // namespace

void WriteSite(const std::string& folder, const SimulatedSite& site) {
  WriteScans(folder, site.scans);
  WriteTum(folder + "/odometry.tum", {site.times, site.odometry});
  WriteTum(folder + "/truth.tum", {site.times, site.truth});
  WriteTextFile(folder + "/truth/planes.json", PlanesAsJson(site.planes));
  WriteTextFile(folder + "/site.yaml", SiteFile(site.name));
}

}  // namespace planegraph
