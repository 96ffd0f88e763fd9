// One plane seen in a drone map and by a scan, with the map's similarity and the scan's pose as
// unknowns: the counterpart of `pose_pose` for maps (ALGORITHMS 6.7). For the map u and the scan d,
// N = R_u n_u:
//
//   r_1 = v_1 . R_d^T N     r_2 = v_2 . R_d^T N (rad, frame of d)
//   r_3 = N . (R_d c_d + t_d - t_u - s R_u c_u) (m of the world)
//
// each over its sigma: the tilts by both sides' tilt, the offset by both sides' offset and the
// map's tilt over the lever arm between the centroids, frozen where the factor is made. A plane
// that k nodes see has weight 2/k, as in `pose_pose`.
#include <ceres/sized_cost_function.h>

#include <cmath>

#include "planegraph/graph/factor_registry.h"
#include "planegraph/graph/factor_sampling.h"
#include "planegraph/graph/manifolds.h"

namespace planegraph {
namespace {

using Eigen::Vector3d;

double Variance(double weight) { return 1.0 / std::max(weight * weight, 1e-12); }

class MapPosePoseCost final : public ceres::SizedCostFunction<3, kMapSize, kPoseSize> {
 public:
  MapPosePoseCost(const PlaneObservation& u, const PlaneObservation& d, double arm)
      : normal_u_(u.axes.col(0)), centroid_u_(u.centroid), centroid_d_(d.centroid) {
    const double tilt_u = std::max(Variance(u.tilt_weight_1), Variance(u.tilt_weight_2));
    weight_1_ = 1.0 / std::sqrt(Variance(d.tilt_weight_1) + tilt_u);
    weight_2_ = 1.0 / std::sqrt(Variance(d.tilt_weight_2) + tilt_u);
    offset_weight_ =
        1.0 / std::sqrt(Variance(d.offset_weight) + Variance(u.offset_weight) + arm * arm * tilt_u);
    axis_1_ = weight_1_ * d.axes.col(1);
    axis_2_ = weight_2_ * d.axes.col(2);
  }

  bool Evaluate(double const* const* blocks, double* residuals, double** jacobians) const override {
    const MapView u(blocks[0]);
    const PoseView d(blocks[1]);
    const Vector3d normal = u.rotation * normal_u_;
    const Vector3d axis_1 = d.rotation * axis_1_, axis_2 = d.rotation * axis_2_;
    const Vector3d turned_d = d.rotation * centroid_d_;
    const Vector3d turned_u = u.scale * (u.rotation * centroid_u_);
    const Vector3d difference = turned_d + d.t - u.t - turned_u;
    residuals[0] = axis_1.dot(normal);
    residuals[1] = axis_2.dot(normal);
    residuals[2] = offset_weight_ * normal.dot(difference);
    if (jacobians == nullptr) return true;
    const Vector3d zero = Vector3d::Zero(), along = offset_weight_ * normal;
    if (jacobians[0] != nullptr) {
      u.SetRow(zero, normal.cross(axis_1), 0.0, jacobians[0]);
      u.SetRow(zero, normal.cross(axis_2), 0.0, jacobians[0] + 8);
      // d/dr of N . y and of -N . s R_u c_u: the rotation of both leaves their product as it is.
      u.SetRow(-along, along.cross(difference + turned_u), -along.dot(turned_u), jacobians[0] + 16);
    }
    if (jacobians[1] != nullptr) {
      d.SetRow(zero, axis_1.cross(normal), jacobians[1]);
      d.SetRow(zero, axis_2.cross(normal), jacobians[1] + 7);
      d.SetRow(along, turned_d.cross(along), jacobians[1] + 14);
    }
    return true;
  }

 private:
  Vector3d normal_u_, centroid_u_, centroid_d_;
  Vector3d axis_1_, axis_2_;  // times their weights
  double weight_1_, weight_2_, offset_weight_;
};

void AddPlane(const Graph& graph, int index, const FactorOptions&, ResidualSink* sink) {
  const auto& seen = graph.planes[index].observations;
  const double weight = 2.0 / static_cast<double>(seen.size());
  for (int u = 0; u < static_cast<int>(seen.size()); ++u) {
    if (seen[u].map < 0) continue;
    for (int d = 0; d < static_cast<int>(seen.size()); ++d) {
      if (seen[d].map >= 0) continue;
      const double arm = (WorldFromObservation(graph, seen[u]) * seen[u].centroid -
                          WorldFromObservation(graph, seen[d]) * seen[d].centroid)
                             .norm();
      sink->Add(std::make_unique<MapPosePoseCost>(seen[u], seen[d], arm),
                {{BlockKind::kMap, seen[u].map}, {BlockKind::kPose, seen[d].pose}},
                ResidualTag{.plane = index, .observation = u, .other_observation = d}, weight);
    }
  }
}

FactorSample Sample(std::mt19937_64* rng) {
  FactorSampler sampler(rng);
  FactorSample sample;
  const PlaneObservation u = sampler.Observation(0), d = sampler.Observation(1);
  sample.cost = std::make_unique<MapPosePoseCost>(u, d, sampler.Uniform(0.0, 1.0));
  sample.kinds = {BlockKind::kMap, BlockKind::kPose};
  sample.values = {FactorSampler::Block(sampler.Map()), FactorSampler::Block(sampler.Pose())};
  return sample;
}

}  // namespace

void Register_map_pose_pose(FactorRegistry* registry) {
  FactorType type;
  type.name = "map_pose_pose";
  type.kind = FactorKind::kMapPlane;
  type.description = "a plane seen in a drone map and by a scan, similarity and pose unknown";
  type.source = "`pose_pose` for a similarity; own derivation";
  type.residual =
      "normal of the map's plane against in-plane axis 1 and 2 of the scan's (rad, its frame), "
      "centroid of the scan's over the map's (m of the world), each over its sigma";
  type.parameters = {
      {"tilt_weight_1", "1/rad", "inverse sigma of the tilt along in-plane axis 1", 1.0, true},
      {"tilt_weight_2", "1/rad", "inverse sigma of the tilt along in-plane axis 2", 1.0, true},
      {"offset_weight", "1/m", "inverse sigma of the offset at the centroid, world", 1.0, true}};
  type.add_plane = AddPlane;
  type.sample = Sample;
  registry->Add(std::move(type));
}

}  // namespace planegraph
