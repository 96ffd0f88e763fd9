// Plane landmark seen in a drone map: the counterpart of `moments` for a similarity (ALGORITHMS
// 6.7).
//
//   r_1 = w_1 v_1 . R^T n        r_2 = w_2 v_2 . R^T n      r_3 = w_o (n . (s R c + t - o) - e)
//
// v_1, v_2: the patch's in-plane axes, c: its centroid (map frame and units); s, R, t:
// world_from_map; n, e: the landmark's normal and its offset from the anchor o (world frame). w_1,
// w_2 in 1/rad, w_o in 1/m of the world. The residual is metric and the scale multiplies the map
// alone, so that a collapsing scale does not make it vanish.
#include <ceres/sized_cost_function.h>

#include "planegraph/graph/factor_registry.h"
#include "planegraph/graph/factor_sampling.h"
#include "planegraph/graph/manifolds.h"

namespace planegraph {
namespace {

using Eigen::Map;
using Eigen::Vector3d;

class MapMomentsCost final : public ceres::SizedCostFunction<3, kMapSize, kPlaneSize> {
 public:
  MapMomentsCost(const PlaneObservation& seen, const Vector3d& anchor)
      : axis_1_(seen.tilt_weight_1 * seen.axes.col(1)),
        axis_2_(seen.tilt_weight_2 * seen.axes.col(2)),
        centroid_(seen.centroid),
        anchor_(anchor),
        offset_weight_(seen.offset_weight) {}

  bool Evaluate(double const* const* blocks, double* residuals, double** jacobians) const override {
    const MapView map(blocks[0]);
    const Vector3d n = Vector3d(Map<const Vector3d>(blocks[1]));
    const Vector3d axis_1 = map.rigid.rotation * axis_1_, axis_2 = map.rigid.rotation * axis_2_;
    const Vector3d turned = map.scale * (map.rigid.rotation * centroid_);
    const Vector3d arm = turned + map.rigid.t - anchor_;
    residuals[0] = axis_1.dot(n);
    residuals[1] = axis_2.dot(n);
    residuals[2] = offset_weight_ * (n.dot(arm) - blocks[1][3]);
    if (jacobians == nullptr) return true;
    if (jacobians[0] != nullptr) {
      const Vector3d zero = Vector3d::Zero();
      map.SetRow(zero, axis_1.cross(n), 0.0, jacobians[0]);
      map.SetRow(zero, axis_2.cross(n), 0.0, jacobians[0] + 8);
      map.SetRow(offset_weight_ * n, offset_weight_ * turned.cross(n),
                 offset_weight_ * n.dot(turned), jacobians[0] + 16);
    }
    if (jacobians[1] != nullptr) {
      Map<Eigen::Matrix<double, 3, 4, Eigen::RowMajor>> plane(jacobians[1]);
      plane.row(0) << axis_1.transpose(), 0.0;
      plane.row(1) << axis_2.transpose(), 0.0;
      plane.row(2) << offset_weight_ * arm.transpose(), -offset_weight_;
    }
    return true;
  }

 private:
  Vector3d axis_1_, axis_2_;  // times their weights
  Vector3d centroid_, anchor_;
  double offset_weight_;
};

void AddPlane(const Graph& graph, int index, const FactorOptions&, ResidualSink* sink) {
  const PlaneLandmark& plane = graph.planes[index];
  for (int k = 0; k < static_cast<int>(plane.observations.size()); ++k) {
    const PlaneObservation& seen = plane.observations[k];
    if (seen.map < 0) continue;
    sink->Add(std::make_unique<MapMomentsCost>(seen, plane.anchor),
              {{BlockKind::kMap, seen.map}, {BlockKind::kPlane, index}},
              ResidualTag{.plane = index, .observation = k}, 1.0);
  }
}

FactorSample Sample(std::mt19937_64* rng) {
  FactorSampler sampler(rng);
  const PlaneLandmark plane = sampler.Landmark();
  FactorSample sample;
  sample.cost = std::make_unique<MapMomentsCost>(sampler.Observation(0), plane.anchor);
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
