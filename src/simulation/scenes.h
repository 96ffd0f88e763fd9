#pragma once

#include "planegraph/simulation/scene.h"

namespace planegraph {

Scene BuildHall(Random* random);
Scene BuildCorridor(Random* random, double max_range);
Scene BuildYard(Random* random);
Scene BuildQuarter(Random* random);

}  // namespace planegraph
