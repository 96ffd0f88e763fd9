// Position of a camera of a drone map by GPS, or by other means (ALGORITHMS 6.6):
//
//   r = L (s R c + t - p)        L^T L = information (3x3, 1/m^2, world's axes)
//
// with (s, R, t) = world_from_map, c the camera's centre in the map, p its position in the world.
#include "factors/node_vectors.h"

namespace planegraph {
namespace {

using Cost = PositionCost<MapView>;

FactorSample Sample(std::mt19937_64* rng) {
  FactorSampler sampler(rng);
  const Eigen::Vector3d in_node = sampler.Point(), in_world = sampler.Point();
  return NodeSample<MapView>(
      std::make_unique<Cost>(in_node, in_world, SampleInformation3(&sampler)), &sampler);
}

}  // namespace

void Register_camera_position(FactorRegistry* registry) {
  FactorType type;
  type.name = "camera_position";
  type.kind = FactorKind::kMap;
  type.description = "position of a camera of a drone map, by GPS";
  type.source = "points under a similarity, Horn 1987; own derivation of the cost";
  type.residual = "camera's centre less its measured position (m, world's axes), whitened";
  type.parameters = {{"point", "map units", "the camera's centre in the map", 0.0, true},
                     {"position", "m", "where it was, world", 0.0, true},
                     {"information", "1/m^2", "3x3, world's axes", 0.0, true}};
  type.make_map_cost = [](const MapFactor& factor) {
    return std::make_unique<Cost>(factor.point, factor.position,
                                  factor.information.topLeftCorner<3, 3>());
  };
  type.sample = Sample;
  registry->Add(std::move(type));
}

}  // namespace planegraph
