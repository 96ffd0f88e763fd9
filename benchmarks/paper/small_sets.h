#pragma once

#include "planegraph/pipeline/mapper.h"

namespace planegraph {

/// Prints, for the scans that stand in a map, what registration costs with the 30 largest planes of
/// the scan and the 150 largest of the map's section about it.
void PrintSmallSets(const MapResult& result);

}  // namespace planegraph
