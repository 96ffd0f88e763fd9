#include "report/viewer_input.h"

#include <cmath>
#include <filesystem>

#include "planegraph/base/atomic_file.h"
#include "planegraph/base/error.h"
#include "planegraph/base/parallel.h"
#include "report/viewer_script.h"

namespace planegraph {
namespace {

// With 12 bytes for a point, before compression, this keeps a report within a mail's size.
constexpr std::size_t kMostViewerPoints = 450000;

// Reads what the view needs and passes over the large rest (patches, masks, range images).
Json ParseOutlines(const std::string& path) {
  const std::string text = ReadTextFile(path);
  const auto wanted = [](int, Json::parse_event_t event, Json& value) {
    return event != Json::parse_event_t::key || (value != "patches" && value != "range_image" &&
                                                 value != "mask" && value != "covariance");
  };
  try {
    return Json::parse(text, wanted);
  } catch (const Json::parse_error& error) {
    throw InputError::AtByte(path, error.byte, "is not valid JSON");
  }
}

ViewerPlane PlaneOf(const Json& json) {
  ViewerPlane plane;
  const auto normal = VectorAt(json, {"normal"});
  const auto distance = NumberAt(json, {"distance"});
  if (!normal || !distance || std::abs(normal->norm() - 1.0) > 1e-6) return plane;
  plane.normal = *normal;
  plane.distance = *distance;
  plane.area = NumberAt(json, {"area"}).value_or(0.0);
  plane.rms = NumberAt(json, {"rms"}).value_or(0.0);
  for (const Json& corner : ListAt(json, {"hull"})) {
    const auto point = VectorOf(corner);
    if (point) plane.hull.push_back(*point);
  }
  if (plane.hull.size() < 3) plane.hull.clear();
  return plane;
}

std::vector<ViewerPlane> ReadPlanesOf(const std::string& path) {
  std::error_code ignored;
  if (!std::filesystem::is_regular_file(path, ignored)) return {};
  const Json outlines = ParseOutlines(path);
  std::vector<ViewerPlane> planes;
  for (const Json& entry : ListAt(outlines, {"planes"})) planes.push_back(PlaneOf(entry));
  return planes;
}

}  // namespace

ViewerInput ReadViewerInput(const std::string& folder, const ReportData& data) {
  ViewerInput input;
  input.script = kViewerScript;
  if (input.script.empty()) return input;
  input.sample = SampleMapPly(folder + "/map.ply", kMostViewerPoints);
  input.planes.resize(data.scans.size());
  ParallelFor(data.scans.size(), 0, [&](std::size_t i) {
    const ReportScan& scan = data.scans[i];
    input.planes[i] = ReadPlanesOf(folder + "/planes/" + scan.robot + "_" + scan.number + ".json");
  });
  return input;
}

}  // namespace planegraph
