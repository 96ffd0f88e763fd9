// The counterpart of `gravity` for a drone map whose vertical is known: ties its tilt to the
// world's (ALGORITHMS 6.6).
//
//   r = L (R u - z)        L^T L = information (3x3, 1/rad^2, world's axes)
//
// with R the rotation of world_from_map, u the direction upwards in the map's frame, z that
// in the world (unit vectors). Small tilts are radians; the heading is free.
#include "factors/node_vectors.h"

namespace planegraph {
namespace {

using Cost = DirectionCost<MapView>;

FactorSample Sample(std::mt19937_64* rng) {
  FactorSampler sampler(rng);
  const Eigen::Vector3d in_node = sampler.UnitVector(), in_world = sampler.UnitVector();
  return NodeSample<MapView>(
      std::make_unique<Cost>(in_node, in_world, SampleInformation3(&sampler)), &sampler);
}

}  // namespace

void Register_map_gravity(FactorRegistry* registry) {
  FactorType type;
  type.name = "map_gravity";
  type.kind = FactorKind::kMap;
  type.description =
      "gravity in a drone map whose vertical is known: ties the tilt to the world's vertical";
  type.source = "`gravity` for a similarity; own derivation";
  type.residual = "map's direction upwards less the world's (rad, world's axes), whitened";
  type.parameters = {{"point", "-", "unit vector upwards in the map's frame", 0.0, true},
                     {"position", "-", "unit vector upwards in the world", 0.0, true},
                     {"information", "1/rad^2", "3x3 of the rotation, world's axes", 0.0, true}};
  type.make_map_cost = [](const MapFactor& factor) {
    return std::make_unique<Cost>(factor.point, factor.position,
                                  factor.information.block<3, 3>(3, 3));
  };
  type.sample = Sample;
  registry->Add(std::move(type));
}

}  // namespace planegraph
