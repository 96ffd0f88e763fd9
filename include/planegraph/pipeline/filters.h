#pragma once

#include <vector>

#include "planegraph/cloud/cloud.h"
#include "planegraph/pipeline/site.h"

namespace planegraph {

/// Drops the points that scanners return where nothing came back: those that share the largest range
/// to the millimetre, where they are too many for chance. Returns their number.
std::size_t DropSaturatedReturns(Cloud* cloud);

/// The default chain (nearer than 0.5 m: the robot itself; saturated returns) or the site's own.
/// Throws UsageError for an unknown step or parameter.
void ApplyFilters(const std::vector<FilterStep>& steps, Cloud* cloud);

}  // namespace planegraph
