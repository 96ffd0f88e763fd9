#include "fuzz/fuzz_reader.h"
#include "io/camera_formats.h"

// The first byte chooses the file of the model.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace planegraph;
  if (size == 0) return 0;
  return FuzzReader(data + 1, size - 1, [&](std::string_view bytes) {
    if (data[0] == 'c') {
      ParseColmapCamerasBinary(bytes, "fuzz");
    } else if (data[0] == 'p') {
      ParseColmapPointsBinary(bytes, "fuzz");
    } else {
      ParseColmapImagesBinary(bytes, {}, "fuzz");
    }
  });
}
