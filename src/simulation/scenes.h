#pragma once

#include "planegraph/simulation/mesh_parts.h"
#include "planegraph/simulation/scene.h"
#include "planegraph/simulation/terrain.h"

namespace planegraph {

Scene BuildHall(Random* random);
Scene BuildCorridor(Random* random, double max_range);
Scene BuildYard(Random* random);
Scene BuildQuarter(Random* random);

/// An upright placement on the ground, turned by `yaw` (radians) about z.
inline Rigid3 OnGround(const Terrain& terrain, const Eigen::Vector2d& at, double yaw) {
  return Upright({at.x(), at.y(), terrain.Height(at)}, yaw);
}

}  // namespace planegraph
