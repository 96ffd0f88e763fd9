// Position of a camera of a drone map by GPS, or by other means (ALGORITHMS 6.6):
//
//   r = L (s R c + t - p)        L^T L = information (3x3, 1/m^2, world's axes)
//
// with (s, R, t) = world_from_map, c the camera's centre in the map, p its position in the world.
#include <ceres/sized_cost_function.h>

#include "factors/square_root.h"
#include "planegraph/geometry/rotation.h"
#include "planegraph/graph/factor_registry.h"
#include "planegraph/graph/factor_sampling.h"
#include "planegraph/graph/manifolds.h"

namespace planegraph {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

class CameraPositionCost final : public ceres::SizedCostFunction<3, kMapSize> {
 public:
  explicit CameraPositionCost(const MapFactor& factor)
      : point_(factor.point),
        position_(factor.position),
        root_(SquareRoot(factor.information.topLeftCorner<3, 3>())) {}

  bool Evaluate(double const* const* blocks, double* residuals, double** jacobians) const override {
    const MapView map(blocks[0]);
    const Vector3d turned = map.scale * (map.rotation * point_);
    Eigen::Map<Vector3d>(residuals, 3) = root_ * (turned + map.t - position_);
    if (jacobians == nullptr || jacobians[0] == nullptr) return true;
    const Matrix3d by_rotation = -root_ * Hat(turned);
    const Vector3d by_scale = root_ * turned;
    for (int k = 0; k < 3; ++k) {
      map.SetRow(root_.row(k), by_rotation.row(k), by_scale[k], jacobians[0] + 8 * k);
    }
    return true;
  }

 private:
  Vector3d point_, position_;
  Matrix3d root_;
};

FactorSample Sample(std::mt19937_64* rng) {
  FactorSampler sampler(rng);
  MapFactor factor;
  factor.point = sampler.Point();
  factor.position = sampler.Point();
  factor.information.topLeftCorner<3, 3>() =
      sampler.Information().topLeftCorner<3, 3>() + Matrix3d::Identity();
  FactorSample sample;
  sample.cost = std::make_unique<CameraPositionCost>(factor);
  sample.kinds = {BlockKind::kMap};
  sample.values = {FactorSampler::Block(sampler.Map())};
  return sample;
}

}  // namespace

void Register_camera_position(FactorRegistry* registry) {
  FactorType type;
  type.name = "camera_position";
  type.kind = FactorKind::kMap;
  type.description = "position of a camera of a drone map, by GPS";
  type.residual = "camera's centre less its measured position (m, world's axes), whitened";
  type.parameters = {{"point", "map units", "the camera's centre in the map", 0.0, true},
                     {"position", "m", "where it was, world", 0.0, true},
                     {"information", "1/m^2", "3x3, world's axes", 0.0, true}};
  type.make_map_cost = [](const MapFactor& factor) {
    return std::make_unique<CameraPositionCost>(factor);
  };
  type.sample = Sample;
  registry->Add(std::move(type));
}

}  // namespace planegraph
