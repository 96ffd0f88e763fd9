// Plane landmark seen in a drone map: the counterpart of `moments` for a similarity (ALGORITHMS
// 6.7).
//
//   r_1 = w_1 v_1 . R^T n        r_2 = w_2 v_2 . R^T n      r_3 = w_o (n . (s R c + t - o) - e)
//
// v_1, v_2: the patch's in-plane axes, c: its centroid (map frame and units); s, R, t:
// world_from_map; n, e: the landmark's normal and its offset from the anchor o (world frame). w_1,
// w_2 in 1/rad, w_o in 1/m of the world. The residual is metric and the scale multiplies the map
// alone, so that a collapsing scale does not make it vanish.
#include "factors/moments_cost.h"
#include "planegraph/graph/factor_registry.h"
#include "planegraph/graph/factor_sampling.h"

namespace planegraph {
namespace {

void AddPlane(const Graph& graph, int index, const FactorOptions&, ResidualSink* sink) {
  const PlaneLandmark& plane = graph.planes[index];
  for (int k = 0; k < static_cast<int>(plane.observations.size()); ++k) {
    const PlaneObservation& seen = plane.observations[k];
    if (seen.map < 0) continue;
    sink->Add(std::make_unique<MomentsCost<MapView>>(seen, plane.anchor),
              {{BlockKind::kMap, seen.map}, {BlockKind::kPlane, index}},
              ResidualTag{.plane = index, .observation = k}, 1.0);
  }
}

FactorSample Sample(std::mt19937_64* rng) {
  FactorSampler sampler(rng);
  const PlaneLandmark plane = sampler.Landmark();
  FactorSample sample;
  sample.cost = std::make_unique<MomentsCost<MapView>>(sampler.Observation(0), plane.anchor);
  sample.kinds = {BlockKind::kMap, BlockKind::kPlane};
  sample.values = {FactorSampler::Block(sampler.Map()), FactorSampler::Block(plane)};
  return sample;
}

}  // namespace

void Register_map_moments(FactorRegistry* registry) {
  FactorType type;
  type.name = "map_moments";
  type.kind = FactorKind::kMapPlane;
  type.description = "plane landmark seen in a drone map of unknown scale, by the patch's moments";
  type.source = "`moments` for a similarity, its scale on the map alone; own derivation";
  type.residual =
      "tilt about in-plane axis 1 and 2 (rad, map frame), offset at the centroid (m of the world, "
      "along the landmark's normal), each over its sigma";
  type.parameters = {
      {"tilt_weight_1", "1/rad", "inverse sigma of the tilt along in-plane axis 1", 1.0, true},
      {"tilt_weight_2", "1/rad", "inverse sigma of the tilt along in-plane axis 2", 1.0, true},
      {"offset_weight", "1/m", "inverse sigma of the offset at the centroid, world", 1.0, true}};
  type.plane_blocks = true;
  type.add_plane = AddPlane;
  type.sample = Sample;
  registry->Add(std::move(type));
}

}  // namespace planegraph
