#pragma once

#include <string>

#include "planegraph/pipeline/map_front_end.h"

namespace planegraph::tools {

/// What --map_memory and --scratch_dir say. `folder` takes the place of an empty --scratch_dir;
/// where both are empty it is the system's folder for temporary files. Throws UsageError.
MapMemory MapMemoryFromFlags(const std::string& folder);

}  // namespace planegraph::tools
