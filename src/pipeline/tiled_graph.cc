#include "pipeline/tiled_graph.h"

#include <cmath>

#include "planegraph/geometry/rotation.h"

namespace planegraph {
namespace {

// Nodes of one map in the graph that is made.
struct MapNodes {
  int first = 0;
  const MapGrid* grid = nullptr;  // null: one node

  int Of(const Eigen::Vector3d& place) const {
    return grid == nullptr ? first : first + grid->TileAt(place);
  }
  int count() const { return grid == nullptr ? 1 : static_cast<int>(grid->count()); }
};

std::vector<MapNodes> AddNodes(const JointSolution& solution, std::vector<MapNode> maps,
                               Graph* graph) {
  std::vector<MapNodes> nodes;
  for (const MapNode& map : maps) {
    const BentMap& bent = solution.bent_maps[map.user_tag];
    const bool cut = bent.grid && !map.fixed;
    nodes.push_back({static_cast<int>(graph->maps.size()), cut ? bent.grid.get() : nullptr});
    if (!cut) graph->maps.push_back(map);
    for (int t = 0; cut && t < nodes.back().count(); ++t) {
      graph->maps.push_back(
          {map.id + "/" + std::to_string(t), bent.world_from_tile[t], false, map.user_tag});
    }
  }
  return nodes;
}

// A measurement of a map without a place in it is of all its tiles; each has its share.
void AddShares(const MapFactor& factor, const MapNodes& nodes, std::vector<MapFactor>* factors) {
  for (int t = 0; t < nodes.count(); ++t) {
    factors->push_back(factor);
    factors->back().maps = {nodes.first + t};
    factors->back().information /= nodes.count();
  }
}

// The scatter of a random walk from tile to tile: its variance is that of the way.
Matrix7d TieInformation(const MapTiling& tiling, double distance) {
  const double sections = distance / MapTiling::kSection;
  Vector7d sigma;
  sigma << Eigen::Vector3d::Constant(tiling.sigma_translation),
      Eigen::Vector3d::Constant(tiling.sigma_rotation), tiling.sigma_scale;
  return (sigma.cwiseAbs2() * sections).cwiseInverse().asDiagonal();
}

void AddTies(const MapNodes& nodes, std::vector<MapFactor>* factors) {
  for (const MapGrid::Tie& tie : nodes.grid->ties()) {
    MapFactor factor;
    factor.type = "map_tie";
    factor.maps = {nodes.first + tie.target, nodes.first + tie.source};
    factor.point = tie.border;
    factor.information = TieInformation(nodes.grid->tiling(), tie.distance);
    factor.source = "tie";
    factors->push_back(std::move(factor));
  }
}

// Heights of the landmarks, which the laser places, over a map's surfaces.
std::vector<MapResidual> HeightsOver(const Graph& graph, std::size_t map) {
  std::vector<MapResidual> heights;
  for (const PlaneLandmark& plane : graph.planes) {
    for (const PlaneObservation& seen : plane.observations) {
      if (seen.map < 0 || graph.maps[seen.map].user_tag != static_cast<int>(map)) continue;
      const Eigen::Vector3d at = WorldFromObservation(graph, seen) * seen.centroid - plane.anchor;
      heights.push_back(
          {plane.anchor, plane.normal, plane.offset - plane.normal.dot(at), 0.0, 0, -1});
    }
  }
  return heights;
}

// The tile that each scan is over, as what the map is there.
double VarianceFactorOfTiles(const JointProblem& problem, const JointSolution& solution,
                             std::size_t map) {
  const BentMap& bent = solution.bent_maps[map];
  const Sim3 metric_from_world = solution.world_from_metric[map].Inverse();
  return MapVarianceFactor(*problem.map_pairs, map, [&](std::size_t scan) {
    const Rigid3& pose = solution.world_from_scan[scan];
    const int tile = bent.grid->TileAt(metric_from_world * pose.translation);
    return bent.world_from_tile[tile].Inverse() * Sim3(pose);
  });
}

// Of a tile's middle, seen from the similarity that stands for all; `by_nodes`: how that moves.
double SigmaOfBend(const GraphCovariance& covariance, const BentMap& bent, const BendingFit& fit,
                   std::size_t tile, std::vector<std::pair<int, Matrix7d>> by_nodes) {
  const Sim3& own = bent.world_from_tile[tile];
  // The same motion of the world about the tile's origin; to first order they are one place.
  const Eigen::Vector3d arm = own.translation - fit.world_from_metric.translation;
  Matrix7d about_own = Matrix7d::Identity();
  about_own.block<3, 3>(0, 3) = -Hat(arm);
  about_own.block<3, 1>(0, 6) = arm;
  for (auto& [node, derivative] : by_nodes) derivative = (-about_own * derivative).eval();
  by_nodes[tile].second += Matrix7d::Identity();
  return SigmaOfPlace(covariance.MapMean(by_nodes), own, bent.grid->Middle(static_cast<int>(tile)));
}

}  // namespace

std::vector<BentMap> LayOutTiles(const JointProblem& problem, const JointSolution& solution) {
  std::vector<BentMap> maps(problem.maps->size());
  for (std::size_t m = 0; m < maps.size(); ++m) {
    const DroneMapSite& site = problem.site->maps[m];
    if (!site.tiles) continue;
    maps[m].grid = std::make_shared<MapGrid>(*site.tiles, (*problem.maps)[m].planes,
                                             solution.world_from_metric[m], site.cloud);
    maps[m].world_from_tile.assign(maps[m].grid->count(), solution.world_from_metric[m]);
  }
  return maps;
}

std::function<const Sim3&(const Eigen::Vector3d& place)> PlaceInTiles(const JointSolution& solution,
                                                                      std::size_t map) {
  const BentMap& bent = solution.bent_maps[map];
  if (!bent.grid) return {};
  return [&bent](const Eigen::Vector3d& place) -> const Sim3& {
    return bent.world_from_tile[bent.grid->TileAt(place)];
  };
}

void CutMaps(const JointSolution& solution, Graph* graph) {
  std::vector<MapNode> maps;
  maps.swap(graph->maps);
  const std::vector<MapNodes> nodes = AddNodes(solution, std::move(maps), graph);
  for (PlaneLandmark& plane : graph->planes) {
    for (PlaneObservation& seen : plane.observations) {
      if (seen.map >= 0) seen.map = nodes[seen.map].Of(seen.centroid);
    }
  }
  std::vector<MapFactor> factors;
  for (MapFactor& factor : graph->map_factors) {
    const MapNodes& own = nodes[factor.maps[0]];
    if (factor.type == "map_gravity") {
      AddShares(factor, own, &factors);
    } else {
      factor.maps = {own.Of(factor.point)};
      factors.push_back(std::move(factor));
    }
  }
  for (const MapNodes& own : nodes) {
    if (own.grid != nullptr) AddTies(own, &factors);
  }
  graph->map_factors = std::move(factors);
}

void TakeMapsOver(const JointProblem& problem, const Graph& graph, JointSolution* solution) {
  for (BentMap& map : solution->bent_maps) map.world_from_tile.clear();
  for (const MapNode& node : graph.maps) {
    BentMap& bent = solution->bent_maps[node.user_tag];
    solution->world_from_metric[node.user_tag] = node.world_from_map;
    if (bent.grid) bent.world_from_tile.push_back(node.world_from_map);
  }
  for (std::size_t m = 0; m < solution->bent_maps.size(); ++m) {
    BentMap& bent = solution->bent_maps[m];
    if (!bent.grid) continue;
    // A map that nothing is registered to has one node.
    bent.world_from_tile.resize(bent.grid->count(), bent.world_from_tile.front());
    solution->world_from_metric[m] = FitBentMap(bent, (*problem.maps)[m].planes).world_from_metric;
  }
}

void WeighBentMaps(const JointProblem& problem, const JointSolution& solution, MapWeights* weights,
                   AssociationOptions* association) {
  bool any = false;
  for (std::size_t m = 0; m < solution.bent_maps.size(); ++m) {
    if (!solution.bent_maps[m].grid) continue;
    any = true;
    weights->errors[m] = MeasureMapErrors(HeightsOver(solution.graph, m));
    weights->factors[m] = VarianceFactorOfTiles(problem, solution, m);
  }
  if (any) AllowForMaps(weights->errors, association);
}

void ComputeMapCovariances(const GraphCovariance& covariance, MapResult* result) {
  const std::vector<MapNode>& nodes = result->solution.graph.maps;
  std::vector<std::vector<int>> of_map(result->maps.size());
  for (std::size_t n = 0; n < nodes.size(); ++n) {
    of_map[nodes[n].user_tag].push_back(static_cast<int>(n));
  }
  result->tile_sigmas.resize(result->maps.size());
  for (std::size_t m = 0; m < of_map.size(); ++m) {
    const BentMap& bent = result->solution.bent_maps[m];
    if (of_map[m].size() == 1) {
      result->map_covariances.push_back(covariance.Map(of_map[m].front()));
      continue;
    }
    const PlaneSet& planes = result->maps[m].planes;
    const BendingFit fit = FitBentMap(bent, planes);
    const std::vector<Matrix7d> by_tiles = FitByTiles(bent, fit, planes);
    std::vector<std::pair<int, Matrix7d>> by_nodes;
    for (std::size_t t = 0; t < by_tiles.size(); ++t)
      by_nodes.push_back({of_map[m][t], by_tiles[t]});
    for (std::size_t t = 0; t < by_tiles.size(); ++t) {
      result->tile_sigmas[m].push_back(SigmaOfBend(covariance, bent, fit, t, by_nodes));
    }
    result->map_covariances.push_back(covariance.MapMean(by_nodes));
  }
}

}  // namespace planegraph
