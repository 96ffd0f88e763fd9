// Relative similarity of two drone maps, or of two tiles of one (ALGORITHMS 6.7), about a point
// that both hold, say on the border of two tiles. With (s_m, R_m, t_m) = target_from_source of the
// measurement, p the point in the target and q in the source, both as the measurement has it:
//
//   d = (s_s R_s q + t_s) - (s_t R_t p + t_t)
//   r = L [ R_t^T d ; Log(R_t^T R_s R_m^T) ; log(s_s / (s_t s_m)) ]      L^T L = information (7x7)
//
// in metres of the world, radians and relative scale, target's axes. Turns and changes of scale
// about the point leave d as it is: where the maps' origins lie does not matter. With an
// information that is the same along all axes nothing changes when target and source change places.
#include <ceres/sized_cost_function.h>

#include <cmath>

#include "factors/square_root.h"
#include "planegraph/geometry/rotation.h"
#include "planegraph/graph/factor_registry.h"
#include "planegraph/graph/factor_sampling.h"
#include "planegraph/graph/manifolds.h"
#include "planegraph/graph/pose_error.h"

namespace planegraph {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using Matrix73 = Eigen::Matrix<double, 7, 3>;

class MapTieCost final : public ceres::SizedCostFunction<7, kMapSize, kMapSize> {
 public:
  MapTieCost(const Sim3& target_from_source, const Vector3d& in_target, const Matrix7d& information)
      : measurement_(target_from_source),
        in_target_(in_target),
        in_source_(target_from_source.Inverse() * in_target),
        root_(SquareRoot(information)) {}

  bool Evaluate(double const* const* blocks, double* residuals, double** jacobians) const override {
    const MapView target(blocks[0]), source(blocks[1]);
    const Vector3d arm_target = target.scale * (target.rotation * in_target_);
    const Vector3d arm_source = source.scale * (source.rotation * in_source_);
    const Vector3d d = arm_source + source.t - arm_target - target.t;
    const Matrix3d to_target = target.rotation.transpose();
    const Eigen::Quaterniond turned =
        Eigen::Quaterniond(target.q).conjugate() * Eigen::Quaterniond(source.q);
    const Vector3d turn = LogSO3(turned * measurement_.rotation.conjugate());
    Vector7d error;
    error << to_target * d, turn, blocks[1][7] - blocks[0][7] - std::log(measurement_.scale);
    Eigen::Map<Vector7d>(residuals, 7) = root_ * error;
    if (jacobians == nullptr) return true;
    const Matrix73 by_place = root_.leftCols<3>() * to_target;
    const Matrix73 by_turn = root_.middleCols<3>(3) * (InverseLeftJacobian(turn) * to_target);
    const Vector7d by_scale = root_.col(6);
    if (jacobians[0] != nullptr) {
      // R_t^T d takes the target's turn, too: d and the arm together are the source's point.
      Write(target, -by_place, by_place * Hat(d + arm_target) - by_turn,
            -by_place * arm_target - by_scale, jacobians[0]);
    }
    if (jacobians[1] != nullptr) {
      Write(source, by_place, by_turn - by_place * Hat(arm_source),
            by_place * arm_source + by_scale, jacobians[1]);
    }
    return true;
  }

 private:
  static void Write(const MapView& map, const Matrix73& dx, const Matrix73& dr, const Vector7d& dl,
                    double* jacobian) {
    for (int k = 0; k < 7; ++k) map.SetRow(dx.row(k), dr.row(k), dl[k], jacobian + kMapSize * k);
  }

  Sim3 measurement_;
  Vector3d in_target_, in_source_;
  Matrix7d root_;
};

FactorSample Sample(std::mt19937_64* rng) {
  FactorSampler sampler(rng);
  const Sim3 target = sampler.Map(), target_from_source = sampler.Map();
  const Vector3d in_target = sampler.Point();
  Matrix7d information = Matrix7d::Zero();
  information.topLeftCorner<6, 6>() = sampler.Information();
  information(6, 6) = sampler.LogUniform(1.0, 1e4);
  FactorSample sample;
  sample.cost = std::make_unique<MapTieCost>(target_from_source, in_target, information);
  sample.kinds = {BlockKind::kMap, BlockKind::kMap};
  // Any error half of the time, a small one otherwise.
  Sim3 source = target * target_from_source;
  if (sampler.Uniform(0.0, 1.0) < 0.5) {
    source = {source.scale * sampler.LogUniform(0.5, 2.0),
              (source.rotation * sampler.Rotation()).normalized(), sampler.Point()};
  } else {
    const Rigid3 near = sampler.Near({source.rotation, source.translation});
    source = {source.scale * sampler.LogUniform(0.99, 1.01), near.rotation, near.translation};
  }
  sample.values = {FactorSampler::Block(target), FactorSampler::Block(source)};
  return sample;
}

}  // namespace

void Register_map_tie(FactorRegistry* registry) {
  FactorType type;
  type.name = "map_tie";
  type.kind = FactorKind::kMap;
  type.description = "relative similarity of two drone maps, or of neighbouring tiles of one";
  type.source =
      "`relative_pose` for similarities about a common point; own derivation (Sim(3) edges: "
      "Strasdat, Montiel and Davison, Scale drift-aware large scale monocular SLAM, 2010)";
  type.residual =
      "common point of the source less the target's (m of the world), rotation vector (rad) and "
      "log of the scale of the estimate against the measurement, target's axes, whitened";
  type.parameters = {
      {"measurement", "m, -", "target_from_source of maps (target, source)", 0.0, true},
      {"point", "target's units", "the common point, target's frame", 0.0, true},
      {"information", "1/m^2, 1/rad^2, -", "7x7, order x y z rx ry rz log(scale)", 0.0, true}};
  type.make_map_cost = [](const MapFactor& factor) {
    return std::make_unique<MapTieCost>(factor.measurement, factor.point, factor.information);
  };
  type.sample = Sample;
  registry->Add(std::move(type));
}

}  // namespace planegraph
