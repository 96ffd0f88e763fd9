#pragma once

#include "planegraph/pipeline/outputs.h"

namespace planegraph {

/// Writes FOLDER/map.ply: the drone maps that scans were joined to, then the scans, all under their
/// poses in the world. At most one drone cloud and a batch of scans are in memory.
void WriteMapPly(const MapResult& result, const OutputOptions& options);

}  // namespace planegraph
