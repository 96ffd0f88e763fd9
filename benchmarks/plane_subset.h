#pragma once

#include <vector>

#include "planegraph/segmentation/plane_segment.h"

namespace planegraph {

/// The planes at `kept`, in that order, with their patches and the rest of the set.
PlaneSet Subset(const PlaneSet& all, const std::vector<std::size_t>& kept);

/// The largest planes of a set, at most `most`, likewise.
PlaneSet LargestPlanes(const PlaneSet& planes, std::size_t most);

}  // namespace planegraph
