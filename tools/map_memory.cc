#include "tools/map_memory.h"

#include <gflags/gflags.h>

#include <cmath>

#include "planegraph/base/error.h"

DEFINE_double(map_memory, 1000.0,
              "MB that the points of a drone map may take; larger clouds are read in parts and "
              "segmented from tiles on disk");
DEFINE_string(scratch_dir, "",
              "folder for the tiles of large drone maps (empty: the output folder, where there is "
              "none that for temporary files)");

namespace planegraph::tools {

MapMemory MapMemoryFromFlags(const std::string& folder) {
  constexpr double kMost = 1e9;
  if (!(FLAGS_map_memory > 0.0) || FLAGS_map_memory > kMost) {
    throw UsageError("--map_memory must be above 0, in megabytes");
  }
  MapMemory memory;
  memory.bytes = static_cast<std::uint64_t>(std::llround(1e6 * FLAGS_map_memory));
  const std::string& wanted = FLAGS_scratch_dir.empty() ? folder : FLAGS_scratch_dir;
  if (!wanted.empty()) memory.scratch = wanted;
  return memory;
}

}  // namespace planegraph::tools
