#pragma once

#include "planegraph/cloud/cloud.h"

namespace planegraph {

/// Whether half of a scan's points are farther than 100 m from its viewpoint, which makes it
/// doubtful that their unit is the metre: from a scanner at a height of 2 m, rays to a flat ground
/// reach that far at 1.1 degrees below the horizon only.
bool AreUnitsDoubtful(const Cloud& cloud);

}  // namespace planegraph
