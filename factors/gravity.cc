// Gravity seen from a scan: ties its tilt to the world's (ALGORITHMS 6.6).
//
//   r = L (R u - z)        L^T L = information (3x3, 1/rad^2, world's axes)
//
// with R the rotation of world_from_node, u the direction upwards in the scan's frame, z that
// in the world (unit vectors). Small tilts are radians; the heading is free.
#include "factors/node_vectors.h"

namespace planegraph {
namespace {

using Cost = DirectionCost<PoseView>;

FactorSample Sample(std::mt19937_64* rng) {
  FactorSampler sampler(rng);
  const Eigen::Vector3d in_node = sampler.UnitVector(), in_world = sampler.UnitVector();
  return NodeSample<PoseView>(
      std::make_unique<Cost>(in_node, in_world, SampleInformation3(&sampler)), &sampler);
}

}  // namespace

void Register_gravity(FactorRegistry* registry) {
  FactorType type;
  type.name = "gravity";
  type.kind = FactorKind::kPose;
  type.description = "gravity as a scan sees it: ties the tilt to the world's vertical";
  type.source = "own derivation: a direction in both frames";
  type.residual = "scan's direction upwards less the world's (rad, world's axes), whitened";
  type.parameters = {
      {"point", "-", "unit vector upwards in the scan's frame", 0.0, true},
      {"measurement", "-", "its translation: unit vector upwards in the world", 0.0, true},
      {"information", "1/rad^2", "3x3 of the rotation, world's axes", 0.0, true}};
  type.make_cost = [](const PoseFactor& factor) {
    return std::make_unique<Cost>(factor.point, factor.measurement.translation,
                                  factor.information.block<3, 3>(3, 3));
  };
  type.sample = Sample;
  registry->Add(std::move(type));
}

}  // namespace planegraph
