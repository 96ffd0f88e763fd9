#include <cstdint>
#include <string_view>

#include "planegraph/base/error.h"
#include "planegraph/correspondence/scan_model.h"
#include "planegraph/segmentation/planes_json.h"

// InputError is a good answer; what is accepted must be fit for registration.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace planegraph;
  try {
    const PlaneSet set =
        ParsePlanes(std::string_view(reinterpret_cast<const char*>(data), size), "fuzz");
    const ScanModel model(set);
  } catch (const InputError&) {
  }
  return 0;
}
