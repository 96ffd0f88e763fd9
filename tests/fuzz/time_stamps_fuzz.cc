#include "fuzz/fuzz_reader.h"
#include "io/trajectory_formats.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace planegraph;
  return FuzzReader(data, size, [](std::string_view bytes) { ParseTimeStamps(bytes, "fuzz"); });
}
