#pragma once

#include <vector>

#include "planegraph/registration/map_registration.h"

namespace planegraph {

/// Poses of the group in the map that the votes of its surfaces name, after a first look by few
/// samples, refined quickly, each with its evidence; in no order, and many of them alike. Those
/// whose scale no prior would have are left out.
std::vector<MapCandidate> SearchMap(const MapModel& map, const ScanGroup& group,
                                    const MapLocationOptions& options);

}  // namespace planegraph
