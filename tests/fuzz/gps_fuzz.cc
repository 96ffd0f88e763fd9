#include "fuzz/fuzz_reader.h"
#include "io/gps_formats.h"

// A reader's promise: positions are on earth.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace planegraph;
  FuzzReader(data, size, [](std::string_view bytes) { ParseImageTimes(bytes, "fuzz"); });
  return FuzzReader(data, size, [](std::string_view bytes) {
    const GpsTrack track = LooksLikeNmea(bytes) ? ParseNmea(bytes) : ParseGpsCsv(bytes, "fuzz");
    for (const GpsFix& fix : track.fixes) {
      if (fix.geodetic.has_value() == track.metric) __builtin_trap();
      if (fix.geodetic && !IsOnEarth(*fix.geodetic)) __builtin_trap();
    }
  });
}
