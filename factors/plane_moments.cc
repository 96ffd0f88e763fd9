// Plane landmark seen by a scan, from the moments of the segment's points: the exact sum of squared
// point-to-plane distances without its constant part (ALGORITHMS 6.2, equation (4) without its
// first component), with an anchored offset (6.4).
//
//   r_1 = w_1 v_1 . R^T n        r_2 = w_2 v_2 . R^T n        r_3 = w_o (n . (R c + t - o) - e)
//
// v_1, v_2: the segment's in-plane axes, c: its centroid (scan frame); R, t: world_from_scan; n, e:
// the landmark's normal and its offset from the anchor o (world frame). w_1, w_2 in 1/rad, w_o in
// 1/m. With w_k^2 = lambda_k / sigma^2 and w_o^2 = N / sigma^2 the cost is that of all N points;
// the thickness lambda_1 that is left out does not move the minimum.
#include "factors/moments_cost.h"
#include "planegraph/graph/factor_registry.h"
#include "planegraph/graph/factor_sampling.h"

namespace planegraph {
namespace {

void AddPlane(const Graph& graph, int index, const FactorOptions&, ResidualSink* sink) {
  const PlaneLandmark& plane = graph.planes[index];
  for (int k = 0; k < static_cast<int>(plane.observations.size()); ++k) {
    const PlaneObservation& seen = plane.observations[k];
    if (seen.map >= 0) continue;  // map_moments
    sink->Add(std::make_unique<MomentsCost<PoseView>>(seen, plane.anchor),
              {{BlockKind::kPose, seen.pose}, {BlockKind::kPlane, index}},
              ResidualTag{.plane = index, .observation = k}, 1.0);
  }
}

FactorSample Sample(std::mt19937_64* rng) {
  FactorSampler sampler(rng);
  const PlaneLandmark plane = sampler.Landmark();
  FactorSample sample;
  sample.cost = std::make_unique<MomentsCost<PoseView>>(sampler.Observation(0), plane.anchor);
  sample.kinds = {BlockKind::kPose, BlockKind::kPlane};
  sample.values = {FactorSampler::Block(sampler.Pose()), FactorSampler::Block(plane)};
  return sample;
}

}  // namespace

void Register_plane_moments(FactorRegistry* registry) {
  FactorType type;
  type.name = "moments";
  type.kind = FactorKind::kPlane;
  type.description = "plane landmark by the moments of its points (exact point-to-plane in O(1))";
  type.source =
      "second moments in place of points, as in BALM (Liu and Zhang, RA-L 2021); own derivation of "
      "the anchored offset";
  type.residual =
      "tilt about in-plane axis 1 and 2 (rad, scan frame), offset at the centroid (m, along the "
      "landmark's normal), each over its sigma";
  type.parameters = {
      {"tilt_weight_1", "1/rad", "inverse sigma of the tilt along in-plane axis 1", 1.0, true},
      {"tilt_weight_2", "1/rad", "inverse sigma of the tilt along in-plane axis 2", 1.0, true},
      {"offset_weight", "1/m", "inverse sigma of the offset at the centroid", 1.0, true}};
  type.plane_blocks = true;
  type.map_counterpart = "map_moments";
  type.add_plane = AddPlane;
  type.sample = Sample;
  registry->Add(std::move(type));
}

}  // namespace planegraph
