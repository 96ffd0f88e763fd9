#include "fuzz/fuzz_reader.h"
#include "planegraph/correspondence/scan_model.h"
#include "planegraph/segmentation/planes_json.h"

// What is accepted must be fit for registration.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace planegraph;
  return FuzzReader(data, size, [](std::string_view bytes) {
    const PlaneSet set = ParsePlanes(bytes, "fuzz");
    const ScanModel model(set);
  });
}
