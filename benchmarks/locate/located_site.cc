#include "locate/located_site.h"

#include <filesystem>
#include <nlohmann/json.hpp>

#include "planegraph/base/atomic_file.h"
#include "planegraph/base/error.h"
#include "planegraph/base/parallel.h"
#include "planegraph/cloud/filters.h"
#include "planegraph/cloud/kd_tree.h"
#include "planegraph/io/trajectory_io.h"

namespace planegraph {
namespace {

std::string SiteFile(const std::string& path) {
  if (!std::filesystem::is_directory(path)) return path;
  for (const char* name : {"site_two_sorties.yaml", "site_nostart.yaml", "site.yaml"}) {
    const std::string file = path + "/" + name;
    if (std::filesystem::exists(file)) return file;
  }
  throw InputError::InFile(path, "has no site file");
}

Sim3 ReadSimilarity(const std::string& path) {
  try {
    const auto json = nlohmann::json::parse(ReadTextFile(path));
    Eigen::Matrix3d rotation;
    Eigen::Vector3d translation;
    for (int r = 0; r < 3; ++r) {
      translation[r] = json.at("t").at(r).get<double>();
      for (int c = 0; c < 3; ++c) rotation(r, c) = json.at("R").at(r).at(c).get<double>();
    }
    return {json.at("scale").get<double>(), Eigen::Quaterniond(rotation).normalized(), translation};
  } catch (const nlohmann::json::exception& error) {
    throw InputError::InFile(path, error.what());
  }
}

void ReadScans(int threads, LocatedSite* located) {
  const auto& robots = located->site.robots;
  std::vector<std::pair<std::size_t, std::size_t>> jobs;
  for (std::size_t r = 0; r < robots.size(); ++r) {
    const Trajectory truth = ReadTrajectory(robots[r].reference);
    if (truth.size() != robots[r].scans.size()) {
      throw InputError::InFile(robots[r].reference, "needs a pose for each scan");
    }
    for (std::size_t i = 0; i < truth.size(); ++i) {
      jobs.push_back({r, i});
      located->world_from_scan.push_back(truth.poses[i]);
    }
  }
  located->scans.resize(jobs.size());
  ParallelFor(jobs.size(), threads, [&](std::size_t k) {
    located->scans[k] = PrepareScan(located->site, jobs[k].first, jobs[k].second, {});
  });
}

// Looked up in the map's true place, so that the share has nothing of the scale by GPS in it.
void MeasureCoverage(int threads, LocatedSite* located) {
  constexpr double kVoxel = 0.25;
  constexpr float kNear = 0.15f;
  const Cloud map = LoadMapCloud(located->site.maps.front(), located->world_from_map);
  const KdTree tree(map.points);
  located->coverage.resize(located->scans.size());
  ParallelFor(located->scans.size(), threads, [&](std::size_t k) {
    const ScanRecord& record = located->scans[k];
    const LoadedScan scan = LoadScan(located->site.robots[record.robot], record.index);
    const Cloud voxels = VoxelFilter(scan.cloud, kVoxel);
    std::vector<KdTree::Neighbour> nearest;
    std::size_t covered = 0;
    for (std::size_t i = 0; i < voxels.size(); ++i) {
      const Eigen::Vector3d place = located->world_from_scan[k] * voxels.Position(i) - map.offset;
      tree.Nearest(place.cast<float>(), 1, &nearest);
      covered += nearest.front().squared_distance <= kNear * kNear;
    }
    located->coverage[k] =
        static_cast<double>(covered) / static_cast<double>(std::max<std::size_t>(voxels.size(), 1));
  });
}

}  // namespace

Sim3 LocatedSite::MetricFromScan(std::size_t scan) const {
  return map.metric_from_map * world_from_map.Inverse() * Sim3(world_from_scan[scan]);
}

LocatedSite ReadLocatedSite(const std::string& path, int threads) {
  const std::string file = SiteFile(path);
  LocatedSite located;
  located.name = path;
  located.site = ReadSite(file);
  if (located.site.maps.empty()) throw InputError::InFile(file, "names no drone map");
  const auto folder = std::filesystem::path(file).parent_path();
  located.world_from_map = ReadSimilarity((folder / "truth/similarity.json").string());
  std::vector<std::string> warnings;
  located.map = PrepareMap(located.site, 0, threads, &warnings);
  if (!warnings.empty()) throw InputError::InFile(file, warnings.front());
  ReadScans(threads, &located);
  MeasureCoverage(threads, &located);
  return located;
}

}  // namespace planegraph
