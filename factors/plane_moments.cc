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
#include <ceres/sized_cost_function.h>

#include "planegraph/graph/factor_registry.h"
#include "planegraph/graph/factor_sampling.h"
#include "planegraph/graph/manifolds.h"

namespace planegraph {
namespace {

using Eigen::Map;
using Eigen::Vector3d;

class PlaneMomentsCost final : public ceres::SizedCostFunction<3, kPoseSize, kPlaneSize> {
 public:
  PlaneMomentsCost(const PlaneObservation& seen, const Vector3d& anchor)
      : axis_1_(seen.tilt_weight_1 * seen.axes.col(1)),
        axis_2_(seen.tilt_weight_2 * seen.axes.col(2)),
        centroid_(seen.centroid),
        anchor_(anchor),
        offset_weight_(seen.offset_weight) {}

  bool Evaluate(double const* const* blocks, double* residuals, double** jacobians) const override {
    const PoseView pose(blocks[0]);
    const Vector3d n = Map<const Vector3d>(blocks[1]);
    const Vector3d axis_1 = pose.rotation * axis_1_, axis_2 = pose.rotation * axis_2_;
    const Vector3d turned = pose.rotation * centroid_;
    const Vector3d arm = turned + pose.t - anchor_;
    residuals[0] = axis_1.dot(n);
    residuals[1] = axis_2.dot(n);
    residuals[2] = offset_weight_ * (n.dot(arm) - blocks[1][3]);
    if (jacobians == nullptr) return true;
    if (jacobians[0] != nullptr) {
      const Vector3d zero = Vector3d::Zero();
      pose.SetRow(zero, axis_1.cross(n), jacobians[0]);
      pose.SetRow(zero, axis_2.cross(n), jacobians[0] + 7);
      pose.SetRow(offset_weight_ * n, offset_weight_ * turned.cross(n), jacobians[0] + 14);
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
    if (seen.map >= 0) continue;  // map_moments
    sink->Add(std::make_unique<PlaneMomentsCost>(seen, plane.anchor),
              {{BlockKind::kPose, seen.pose}, {BlockKind::kPlane, index}},
              ResidualTag{.plane = index, .observation = k}, 1.0);
  }
}

FactorSample Sample(std::mt19937_64* rng) {
  FactorSampler sampler(rng);
  const PlaneLandmark plane = sampler.Landmark();
  FactorSample sample;
  sample.cost = std::make_unique<PlaneMomentsCost>(sampler.Observation(0), plane.anchor);
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
  type.residual =
      "tilt about in-plane axis 1 and 2 (rad, scan frame), offset at the centroid (m, along the "
      "landmark's normal), each over its sigma";
  type.parameters = {
      {"tilt_weight_1", "1/rad", "inverse sigma of the tilt along in-plane axis 1", 1.0, true},
      {"tilt_weight_2", "1/rad", "inverse sigma of the tilt along in-plane axis 2", 1.0, true},
      {"offset_weight", "1/m", "inverse sigma of the offset at the centroid", 1.0, true}};
  type.plane_blocks = true;
  type.add_plane = AddPlane;
  type.sample = Sample;
  registry->Add(std::move(type));
}

}  // namespace planegraph
