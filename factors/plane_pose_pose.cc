// One plane seen by two scans, with pose unknowns only (ALGORITHMS 6.3, equation (5)). For scans m
// and d, N = R_m n_m, y = R_d c_d + t_d - t_m:
//
//   r_1 = v_1 . R_d^T N    r_2 = v_2 . R_d^T N (rad, frame of d)    r_3 = N . y - n_m . c_m (m)
//
// whitened by the covariance of both sides, frozen at the poses at which the factor is made. All
// pairs of a plane's k observations are used, each with weight 2/k: for equal qualities this is the
// cost of the landmark form, and without it the information is counted k/2 times.
#include <ceres/sized_cost_function.h>

#include <Eigen/Cholesky>
#include <cmath>

#include "planegraph/graph/factor_registry.h"
#include "planegraph/graph/factor_sampling.h"
#include "planegraph/graph/manifolds.h"

namespace planegraph {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

// A weight of zero is an unknown; a large variance (sigma 1e6) stands for it.
double Variance(double weight) { return 1.0 / std::max(weight * weight, 1e-12); }

// Covariance of the unwhitened residual: d's own, m's normal carried over the lever arm, m's
// offset.
Matrix3d ResidualCovariance(const PlaneObservation& m, const PlaneObservation& d,
                            const Rigid3& m_from_d) {
  const Vector3d arm = m_from_d * d.centroid - m.centroid;
  Matrix3d j;
  j.topRows<2>() = (m_from_d.rotation.toRotationMatrix() * d.axes.rightCols<2>()).transpose();
  j.row(2) = arm.transpose();
  const Matrix3d normal_covariance =
      Variance(m.tilt_weight_1) * m.axes.col(1) * m.axes.col(1).transpose() +
      Variance(m.tilt_weight_2) * m.axes.col(2) * m.axes.col(2).transpose();
  Matrix3d covariance = j * normal_covariance * j.transpose();
  covariance.diagonal() += Vector3d(Variance(d.tilt_weight_1), Variance(d.tilt_weight_2),
                                    Variance(d.offset_weight) + Variance(m.offset_weight));
  return covariance;
}

class PlanePosePoseCost final : public ceres::SizedCostFunction<3, kPoseSize, kPoseSize> {
 public:
  PlanePosePoseCost(const PlaneObservation& m, const PlaneObservation& d, const Rigid3& m_from_d)
      : normal_m_(m.axes.col(0)),
        centroid_d_(d.centroid),
        axes_d_(d.axes.rightCols<2>()),
        distance_m_(m.axes.col(0).dot(m.centroid)),
        whitening_(ResidualCovariance(m, d, m_from_d)
                       .llt()
                       .matrixL()
                       .solve(Matrix3d(Matrix3d::Identity()))) {}

  bool Evaluate(double const* const* blocks, double* residuals, double** jacobians) const override {
    const PoseView m(blocks[0]), d(blocks[1]);
    const Vector3d normal = m.rotation * normal_m_;
    const Vector3d turned = d.rotation * centroid_d_;
    const Vector3d y = turned + d.t - m.t;
    const Eigen::Matrix<double, 3, 2> axes = d.rotation * axes_d_;
    Vector3d r;
    r << axes.transpose() * normal, normal.dot(y) - distance_m_;
    Eigen::Map<Vector3d>(residuals, 3) = whitening_ * r;
    if (jacobians == nullptr) return true;
    // Rows of d r / d rotation; both are whitened before they are written.
    Matrix3d by_m, by_d;
    by_d << axes.col(0).cross(normal).transpose(), axes.col(1).cross(normal).transpose(),
        turned.cross(normal).transpose();
    by_m << -by_d.topRows<2>(), normal.cross(y).transpose();
    if (jacobians[0] != nullptr) SetRows(m, -normal, by_m, jacobians[0]);
    if (jacobians[1] != nullptr) SetRows(d, normal, by_d, jacobians[1]);
    return true;
  }

 private:
  // Only the third unwhitened row depends on the translation.
  void SetRows(const PoseView& pose, const Vector3d& by_translation, const Matrix3d& by_rotation,
               double* jacobian) const {
    const Matrix3d rotation_rows = whitening_ * by_rotation;
    for (int row = 0; row < 3; ++row) {
      pose.SetRow(whitening_(row, 2) * by_translation, rotation_rows.row(row), jacobian + 7 * row);
    }
  }

  Vector3d normal_m_, centroid_d_;
  Eigen::Matrix<double, 3, 2> axes_d_;
  double distance_m_;
  Matrix3d whitening_;
};

void AddPlane(const Graph& graph, int index, const FactorOptions& options, ResidualSink* sink) {
  const auto& seen = graph.planes[index].observations;
  const int count = static_cast<int>(seen.size());  // those in maps count in the weight, too
  const double weight = OptionOr(options, "count_once", 1.0) != 0.0 ? 2.0 / count : 1.0;
  for (int m = 0; m < count; ++m) {
    for (int d = m + 1; d < count; ++d) {
      if (seen[m].map >= 0 || seen[d].map >= 0) continue;  // map_pose_pose
      if (seen[m].pose == seen[d].pose) continue;
      const Rigid3 m_from_d = graph.poses[seen[m].pose].world_from_node.Inverse() *
                              graph.poses[seen[d].pose].world_from_node;
      sink->Add(std::make_unique<PlanePosePoseCost>(seen[m], seen[d], m_from_d),
                {{BlockKind::kPose, seen[m].pose}, {BlockKind::kPose, seen[d].pose}},
                ResidualTag{.plane = index, .observation = m, .other_observation = d}, weight);
    }
  }
}

FactorSample Sample(std::mt19937_64* rng) {
  FactorSampler sampler(rng);
  const Rigid3 m = sampler.Pose(), d = sampler.Pose();
  FactorSample sample;
  sample.cost = std::make_unique<PlanePosePoseCost>(sampler.Observation(0), sampler.Observation(1),
                                                    m.Inverse() * d);
  sample.kinds = {BlockKind::kPose, BlockKind::kPose};
  sample.values = {FactorSampler::Block(m), FactorSampler::Block(d)};
  return sample;
}

}  // namespace

void Register_plane_pose_pose(FactorRegistry* registry) {
  FactorType type;
  type.name = "pose_pose";
  type.kind = FactorKind::kPlane;
  type.description = "a plane seen by two scans, all pairs, pose unknowns only";
  type.source =
      "plane correspondences between scans, Pathak, Birk et al.: Fast registration based on noisy "
      "planes, T-RO 2010; weight 2/k of the pairs (own)";
  type.residual =
      "normal of the first scan against in-plane axis 1 and 2 of the second (rad, its frame), "
      "centroid "
      "of the second over the first's plane (m); whitened by both covariances, frozen per solve";
  type.parameters = {
      {"count_once", "-", "1: weight 2/k per pair of a plane seen k times; 0: every pair counts",
       1.0, false},
      {"tilt_weight_1", "1/rad", "inverse sigma of the tilt along in-plane axis 1", 1.0, true},
      {"tilt_weight_2", "1/rad", "inverse sigma of the tilt along in-plane axis 2", 1.0, true},
      {"offset_weight", "1/m", "inverse sigma of the offset at the centroid", 1.0, true}};
  type.map_counterpart = "map_pose_pose";
  type.add_plane = AddPlane;
  type.sample = Sample;
  registry->Add(std::move(type));
}

}  // namespace planegraph
