// Position of a robot's antenna by GPS, or by other means (ALGORITHMS 6.6):
//
//   r = L (R a + t - p)        L^T L = information (3x3, 1/m^2, world's axes)
//
// with (R, t) = world_from_node, a the antenna in the scan's frame (the lever arm), p its position
// in the world.
#include "factors/node_vectors.h"

namespace planegraph {
namespace {

using Cost = PositionCost<PoseView>;

FactorSample Sample(std::mt19937_64* rng) {
  FactorSampler sampler(rng);
  const Eigen::Vector3d in_node = sampler.Point(), in_world = sampler.Point();
  return NodeSample<PoseView>(
      std::make_unique<Cost>(in_node, in_world, SampleInformation3(&sampler)), &sampler);
}

}  // namespace

void Register_robot_position(FactorRegistry* registry) {
  FactorType type;
  type.name = "robot_position";
  type.kind = FactorKind::kPose;
  type.description = "position of a robot's antenna, by GPS";
  type.source = "GPS with a lever arm as a unary factor (Dellaert and Kaess 2017); own derivation";
  type.residual = "antenna less its measured position (m, world's axes), whitened";
  type.parameters = {{"point", "m", "the antenna in the scan's frame", 0.0, true},
                     {"measurement", "m", "its translation: where it was, world", 0.0, true},
                     {"information", "1/m^2", "upper left 3x3, world's axes", 0.0, true}};
  type.make_cost = [](const PoseFactor& factor) {
    return std::make_unique<Cost>(factor.point, factor.measurement.translation,
                                  factor.information.topLeftCorner<3, 3>());
  };
  type.sample = Sample;
  registry->Add(std::move(type));
}

}  // namespace planegraph
