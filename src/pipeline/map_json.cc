#include "pipeline/map_json.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "pipeline/json_values.h"

namespace planegraph {
namespace {

using Json = nlohmann::json;

Json GeoreferenceJson(const Georeference& g) {
  return {{"status", g.status},
          {"reason", g.reason},
          {"scale", Number(g.world_from_map.scale)},
          {"sigma_scale", Number(g.sigma_scale)},
          {"rms", Number(g.rms)},
          {"inliers", g.inliers.size()},
          {"fixes", g.fixes.size()}};
}

// Where the pictures were taken, in the world.
Json CamerasJson(const MapRecord& map, const Sim3& world_from_map) {
  Json list = Json::array();
  if (!map.georeference) return list;
  for (const CameraFix& fix : map.georeference->fixes) {
    list.push_back(Array(Eigen::Vector3d(world_from_map * fix.centre_in_map)));
  }
  return list;
}

// What the laser has seen of each tile: surfaces.
std::vector<int> SeenByTile(const MapResult& result, std::size_t m) {
  const Graph& graph = result.solution.graph;
  std::vector<int> seen(graph.maps.size(), 0);
  for (const PlaneLandmark& plane : graph.planes) {
    for (const PlaneObservation& one : plane.observations) {
      if (one.map >= 0) ++seen[one.map];
    }
  }
  std::vector<int> of_map;
  for (std::size_t n = 0; n < seen.size(); ++n) {
    if (graph.maps[n].user_tag == static_cast<int>(m)) of_map.push_back(seen[n]);
  }
  return of_map;
}

// The tiles of a bent map, and how far they are off the similarity that stands for the whole.
Json TilesJson(const MapResult& result, std::size_t m) {
  const BentMap& bent = result.solution.bent_maps[m];
  const MapRecord& map = result.maps[m];
  const BendingFit fit = FitBentMap(bent, map.planes);
  const MapTiling& tiling = bent.grid->tiling();
  const std::vector<int> seen = SeenByTile(result, m);
  Json nodes = Json::array();
  for (std::size_t t = 0; t < bent.world_from_tile.size(); ++t) {
    const Eigen::Vector3d& middle = bent.grid->Middle(static_cast<int>(t));
    const Eigen::Vector3d at = bent.world_from_tile[t] * middle;
    const bool known = t < result.tile_sigmas[m].size();
    nodes.push_back(
        {{"middle", Array(at)},
         {"world_from_map", SimilarityJson(bent.world_from_tile[t] * map.metric_from_map)},
         {"bent", Array(Eigen::Vector3d(at - fit.world_from_metric * middle))},
         {"sigma", known ? Number(result.tile_sigmas[m][t]) : Json(nullptr)},
         {"surfaces", t < seen.size() ? seen[t] : 0}});
  }
  return {{"size", tiling.size},
          {"sigma_scale", tiling.sigma_scale},
          {"sigma_rotation_deg", tiling.sigma_rotation * 180.0 / std::numbers::pi},
          {"sigma_translation", tiling.sigma_translation},
          {"rms", fit.rms},
          {"largest", fit.largest},
          {"nodes", nodes}};
}

}  // namespace

nlohmann::json MapJson(const MapResult& result, std::size_t m) {
  const MapRecord& map = result.maps[m];
  Json json = {{"id", map.id},
               {"points", map.points},
               {"planes", map.planes.planes.size()},
               {"patches", map.planes.patches.size()},
               {"noise", {{"constant", map.planes.noise.constant}}},
               {"world_from_map",
                SimilarityJson(result.solution.world_from_metric[m] * map.metric_from_map)},
               {"sigma_scale", nullptr},
               {"covariance", nullptr},
               {"georeference", nullptr},
               {"seconds", {{"read", map.seconds_read}, {"segment", map.seconds_segment}}}};
  if (map.georeference) json["georeference"] = GeoreferenceJson(*map.georeference);
  json["cameras"] = CamerasJson(map, result.solution.world_from_metric[m] * map.metric_from_map);
  if (m < result.solution.bent_maps.size() && result.solution.bent_maps[m].grid) {
    json["tiles"] = TilesJson(result, m);
  }
  // Without a scan in it the joint solve says nothing of a map.
  const bool joined = std::any_of(result.map_pairs.begin(), result.map_pairs.end(),
                                  [m](const auto& pair) { return pair.used && pair.map == m; });
  if (joined && m < result.map_covariances.size()) {
    json["sigma_scale"] = Number(std::sqrt(result.map_covariances[m](6, 6)));
    json["covariance"] = MatrixJson(result.map_covariances[m]);
  }
  return json;
}

}  // namespace planegraph
