// Drone maps that are bent like a bowl, as one similarity and as tiles, from files to poses.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <optional>

#include "io/test_files.h"
#include "planegraph/geometry/alignment.h"
#include "planegraph/io/cloud_io.h"
#include "planegraph/io/g2o_io.h"
#include "planegraph/pipeline/mapper.h"
#include "planegraph/pipeline/outputs.h"
#include "planegraph/simulation/simulation.h"

namespace planegraph {
namespace {

// Two robots in two streets, over most of the map.
SimulatedSite Quarter(double bowl, std::uint64_t seed) {
  SimulationOptions options;
  options.scene = SceneKind::kQuarter;
  options.seed = seed;
  options.scans = 9;
  options.scanner.beams = 361;
  options.scanner.sweeps = 120;
  options.drone.photogrammetry.bowl = bowl;
  return Simulate(options);
}

MapOptions Options() {
  MapOptions options;
  options.threads = 2;
  return options;
}

const Rigid3& TruthOf(const MapResult& result, const SimulatedSite& site, std::size_t scan) {
  return site.robots[result.scans[scan].robot].truth[result.scans[scan].index];
}

// The truth's world from the result's, by the scans.
Sim3 TruthFromResult(const MapResult& result, const SimulatedSite& site) {
  std::vector<Eigen::Vector3d> found, truth;
  for (std::size_t i = 0; i < result.scans.size(); ++i) {
    found.push_back(result.solution.world_from_scan[i].translation);
    truth.push_back(TruthOf(result, site, i).translation);
  }
  return AlignPoints(found, truth, false).target_from_source;
}

// Root mean square error of the scans' positions after alignment, metres.
double ErrorOfScans(const MapResult& result, const SimulatedSite& site) {
  const Sim3 align = TruthFromResult(result, site);
  double sum = 0.0;
  for (std::size_t i = 0; i < result.scans.size(); ++i) {
    const Eigen::Vector3d found = align * result.solution.world_from_scan[i].translation;
    sum += (found - TruthOf(result, site, i).translation).squaredNorm();
  }
  return std::sqrt(sum / static_cast<double>(result.scans.size()));
}

// What the run itself says of the scans' positions, seen from the first one, metres.
double SigmaOfScans(const MapResult& result) {
  double sum = 0.0;
  for (std::size_t i = 1; i < result.scans.size(); ++i) {
    sum += result.covariance->Relative(0, static_cast<int>(i)).topLeftCorner<3, 3>().trace();
  }
  return std::sqrt(sum / static_cast<double>(result.scans.size()));
}

// Median distance of the map's points from the true planes, in the scans' world, metres.
double ErrorOfMap(const MapResult& result, const SimulatedSite& site) {
  const Sim3 align = TruthFromResult(result, site);
  const PhotogrammetryModel& model = site.drone->model;
  const BentMap& bent = result.solution.bent_maps[0];
  std::vector<double> off;
  for (std::size_t i = 0; i < model.cloud.size(); i += 7) {
    if (model.labels[i] < 0) continue;
    const Eigen::Vector3d place = result.maps[0].metric_from_map * model.cloud.Position(i);
    const Eigen::Vector3d world =
        bent.grid ? bent * place : result.solution.world_from_metric[0] * place;
    off.push_back(std::abs(site.planes[model.labels[i]].SignedDistance(align * world)));
  }
  const auto middle = off.begin() + static_cast<std::ptrdiff_t>(off.size() / 2);
  std::nth_element(off.begin(), middle, off.end());
  return *middle;
}

class BentQuarter : public TestFolder {
 protected:
  MapResult Run(const SimulatedSite& truth, const std::optional<MapTiling>& tiles) {
    WriteSite(Path("site"), truth);
    Site site = ReadSite(Path("site/site.yaml"));
    site.maps[0].tiles = tiles;
    return MapScans(site, Options());
  }
};

// What such a bowl bends a map by: a tilt of half a degree and more from tile to tile.
MapTiling Loose() {
  MapTiling tiling;
  tiling.size = 15.0;
  tiling.sigma_rotation *= 10.0;
  tiling.sigma_translation = 0.1;
  return tiling;
}

TEST_F(BentQuarter, TilesFollowABowlThatOneSimilarityCannot) {
  for (const std::uint64_t seed : {5, 6}) {
    const SimulatedSite site = Quarter(0.01, seed);
    const MapResult whole = Run(site, {}), tiles = Run(site, Loose());
    EXPECT_FALSE(whole.solution.bent_maps[0].grid);
    // What the points' own noise leaves is the map without a bowl.
    EXPECT_LT(ErrorOfMap(tiles, site), 0.7 * ErrorOfMap(whole, site)) << seed;
    // The laser holds the scans to each other; the map may not bend them, either way.
    EXPECT_LT(ErrorOfScans(tiles, site), ErrorOfScans(whole, site) + 3.0 * SigmaOfScans(tiles));
    const double sigma = std::sqrt(tiles.map_covariances[0](6, 6));
    const Sim3 found = tiles.solution.world_from_metric[0] * tiles.maps[0].metric_from_map;
    EXPECT_LT(std::abs(std::log(found.scale / site.drone->model.world_from_map.scale)),
              4.0 * sigma);
  }
}

TEST_F(BentQuarter, AMapThatIsNotBentStaysAsGood) {
  const SimulatedSite site = Quarter(0.0, 5);
  const MapResult whole = Run(site, {}), tiles = Run(site, MapTiling());
  EXPECT_LT(ErrorOfMap(tiles, site), 1.1 * ErrorOfMap(whole, site));
  EXPECT_LT(ErrorOfScans(tiles, site), ErrorOfScans(whole, site) + 3.0 * SigmaOfScans(tiles));
  // The tiles' own sigmas are honest about how far they seem to be bent.
  const BendingFit fit = FitBentMap(tiles.solution.bent_maps[0], tiles.maps[0].planes);
  const auto& sigmas = tiles.tile_sigmas[0];
  EXPECT_LT(fit.rms, 3.0 * *std::max_element(sigmas.begin(), sigmas.end()));
}

TEST_F(BentQuarter, TheOutputsSayHowTheMapIsBent) {
  const SimulatedSite site = Quarter(0.01, 7);
  const MapResult result = Run(site, Loose());
  const auto report = nlohmann::json::parse(ReportJson(result, Options()));
  const auto& tiles = report["maps"][0]["tiles"];
  const BentMap& bent = result.solution.bent_maps[0];
  ASSERT_EQ(tiles["nodes"].size(), bent.grid->count());
  EXPECT_EQ(tiles["size"], 15.0);
  EXPECT_GT(tiles["largest"], tiles["rms"]);
  int surfaces = 0;
  for (const auto& node : tiles["nodes"]) {
    EXPECT_GT(node["sigma"], 0.0);
    surfaces += node["surfaces"].get<int>();
  }
  EXPECT_GT(surfaces, 100);
  WriteOutputs(result, {Path("out"), 0.2, 2});
  EXPECT_EQ(ReadG2o(Path("out/graph.g2o")).vertices3.size(), result.scans.size());
  const Cloud map = ReadCloud(Path("out/map.ply"));
  EXPECT_GT(map.size(), 1000u);
}

}  // namespace
}  // namespace planegraph
