#include "tools/map_memory.h"

#include <gflags/gflags.h>

#include "planegraph/base/error.h"

DEFINE_int32(map_memory, 1000,
             "MB that the points of a drone map may take; larger clouds are read in parts and "
             "segmented from tiles on disk");
DEFINE_string(scratch_dir, "",
              "folder for the tiles of large drone maps (empty: the output folder, where there is "
              "none that for temporary files)");

namespace planegraph::tools {

MapMemory MapMemoryFromFlags(const std::string& folder) {
  if (FLAGS_map_memory <= 0) throw UsageError("--map_memory must be above 0, in megabytes");
  MapMemory memory;
  memory.bytes = static_cast<std::uint64_t>(FLAGS_map_memory) * 1000000;
  const std::string& wanted = FLAGS_scratch_dir.empty() ? folder : FLAGS_scratch_dir;
  if (!wanted.empty()) memory.scratch = wanted;
  return memory;
}

}  // namespace planegraph::tools
