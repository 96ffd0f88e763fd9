#include "fuzz/fuzz_reader.h"
#include "io/gps_formats.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace planegraph;
  return FuzzReader(data, size, [](std::string_view bytes) {
    const auto position = ParseExifPosition(bytes);
    if (position && !IsOnEarth(*position)) __builtin_trap();
  });
}
