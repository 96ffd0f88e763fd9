#include "fuzz/fuzz_reader.h"
#include "io/camera_formats.h"

namespace {

// A reader's promise: registered cameras have finite poses, points are finite.
void CheckModel(const planegraph::CameraModel& model) {
  bool good = true;
  for (const auto& camera : model.cameras) good = good && camera.Centre().allFinite();
  for (const auto& point : model.points) good = good && point.allFinite();
  if (!good) __builtin_trap();
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace planegraph;
  return FuzzReader(data, size, [](std::string_view bytes) {
    if (bytes.starts_with("[")) {
      CheckModel(ParseOpenSfm(bytes, "fuzz"));
    } else if (LooksLikeBundle(bytes)) {
      CheckModel(ParseBundle(bytes, "fuzz"));
    } else {
      CameraModel model;
      model.cameras = ParseColmapImages(bytes, ParseColmapCameras("1 M 1 1 5\n", "c"), "fuzz");
      CheckModel(model);
    }
  });
}
