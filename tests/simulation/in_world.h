#pragma once

#include "planegraph/simulation/photogrammetry.h"

namespace planegraph {

/// A point of the model, in the world.
inline Eigen::Vector3d InWorld(const PhotogrammetryModel& model, std::size_t i) {
  return model.world_from_map * model.cloud.Position(i);
}

}  // namespace planegraph
