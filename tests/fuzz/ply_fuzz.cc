#include <sstream>

#include "fuzz/fuzz_reader.h"
#include "io/cloud_formats.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace planegraph;
  FuzzReader(data, size, [](std::string_view bytes) {
    std::istringstream stream{std::string(bytes)};
    const auto map = ParseMapPly(&stream, "fuzz");
    if (!map) return;
    CheckCloud(map->laser);
    CheckCloud(map->vision);
  });
  FuzzReader(data, size, [](std::string_view bytes) {
    const auto labelled = ParseLabelledPly(bytes, "fuzz");
    if (!labelled) return;
    CheckCloud(labelled->cloud);
    const std::size_t count = labelled->cloud.size();
    if (labelled->planes.size() != count || labelled->scans.size() != count ||
        labelled->vision.size() != count) {
      __builtin_trap();
    }
  });
  return FuzzReader(data, size,
                    [](std::string_view bytes) { CheckCloud(ParsePly(bytes, "fuzz")); });
}
