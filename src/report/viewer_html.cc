#include "report/viewer_html.h"

#include <algorithm>
#include <cmath>

#include "report/html.h"
#include "report/png.h"
#include "report/viewer_points.h"

namespace planegraph {
namespace {

constexpr int kViewerCompression = 5;

bool HasScene(const ReportData& data, const ViewerInput& input) {
  return !data.Positions().empty() || !input.sample.points.empty();
}

// Rounded to `per_metre` parts of a metre, which prints short.
Json Numbers(const Eigen::Vector3d& v, double per_metre) {
  Json list = Json::array();
  for (int axis = 0; axis < 3; ++axis) list.push_back(std::round(v[axis] * per_metre) / per_metre);
  return list;
}

// ---- scene ----

Json ScansJson(const ReportData& data) {
  Json list = Json::array();
  for (const ReportScan& scan : data.scans) {
    list.push_back({{"id", scan.id},
                    {"robot", scan.robot_index},
                    {"component", scan.component.value_or(-1)},
                    {"at", scan.position ? Numbers(*scan.position, 1e3) : Json(nullptr)}});
  }
  return list;
}

std::ptrdiff_t IndexOf(const ReportData& data, const std::string& id) {
  const ReportScan* scan = data.Find(id);
  return scan == nullptr ? -1 : scan - data.scans.data();
}

// Of each registration the indices of its scans; -1 stands for a drone map, or for nothing.
Json RegistrationsJson(const ReportData& data) {
  Json list = Json::array();
  for (const Json& r : ListAt(*data.json, {"registrations"})) {
    const bool map = TextAt(r, {"kind"}) == "laser-map";
    list.push_back(
        {map ? -1 : IndexOf(data, TextAt(r, {"target"})), IndexOf(data, TextAt(r, {"source"}))});
  }
  return list;
}

// A plane of the world, its corners in whole centimetres from the box's corner.
struct Outline {
  std::size_t scan, number;
  const ViewerPlane* plane;
};

Json OutlineJson(const Outline& outline, const Rigid3& pose, const Eigen::Vector3d& low) {
  constexpr double kCentimetres = 100.0;
  Json corners = Json::array();
  for (const Eigen::Vector3d& corner : outline.plane->hull) {
    const Eigen::Vector3d at = kCentimetres * (pose * corner - low);
    for (int axis = 0; axis < 3; ++axis) {
      corners.push_back(static_cast<std::int64_t>(std::llround(std::clamp(at[axis], -1e9, 1e9))));
    }
  }
  return {outline.scan, outline.number, std::round(outline.plane->area * 100.0) / 100.0,
          std::round(outline.plane->rms * 1e5) / 1e5, corners};
}

// The largest planes, up to a budget of corners, by scan and number.
Json PlanesJson(const ReportData& data, const ViewerInput& input, const ViewerBox& box) {
  constexpr std::size_t kMostCorners = 60000;
  std::vector<Outline> outlines;
  for (std::size_t i = 0; i < std::min(input.planes.size(), data.scans.size()); ++i) {
    for (std::size_t k = 0; k < input.planes[i].size(); ++k) {
      if (!input.planes[i][k].hull.empty()) outlines.push_back({i, k, &input.planes[i][k]});
    }
  }
  std::stable_sort(outlines.begin(), outlines.end(), [](const Outline& a, const Outline& b) {
    return a.plane->area > b.plane->area;
  });
  Json list = Json::array();
  std::size_t corners = 0;
  for (const Outline& outline : outlines) {
    const auto pose = PoseOf(data.scans[outline.scan]);
    corners += outline.plane->hull.size();
    if (corners > kMostCorners) break;
    if (pose) list.push_back(OutlineJson(outline, *pose, box.low));
  }
  return list;
}

Json CamerasJson(const ReportData& data) {
  Json list = Json::array();
  for (const ReportMap& map : data.maps) {
    for (const Json& camera : ListAt(*map.json, {"cameras"})) {
      const auto at = VectorOf(camera);
      if (at && at->cwiseAbs().maxCoeff() < 1e8) list.push_back(Numbers(*at, 100.0));
    }
  }
  return list;
}

Json SceneJson(const ReportData& data, const ViewerInput& input, const ViewerBox& box,
               const ViewerPoints& points) {
  Json runs = Json::array(), maps = Json::array();
  for (const ViewerRun& run : points.runs) runs.push_back({run.scan, run.count});
  for (const ReportMap& map : data.maps) maps.push_back(map.id);
  return {{"low", Numbers(box.low, 1e6)},
          {"extent", Numbers(box.extent, 1e6)},
          {"count", points.count},
          {"total", input.sample.total},
          {"residual_step", points.residual_step},
          {"runs", runs},
          {"robots", data.robots},
          {"maps", maps},
          {"scans", ScansJson(data)},
          {"registrations", RegistrationsJson(data)},
          {"planes", PlanesJson(data, input, box)},
          {"cameras", CamerasJson(data)}};
}

// JSON in a script element must not close it.
std::string ForScript(const Json& json) {
  std::string text;
  for (const char c : json.dump(-1, ' ', true, Json::error_handler_t::replace)) {
    text += c == '<' ? std::string("\\u003c") : std::string(1, c);
  }
  return text;
}

}  // namespace

std::string ViewerHtml(const ReportData& data, const ViewerInput& input) {
  if (!HasScene(data, input)) return "";
  if (input.script.empty()) {
    return "<p class=\"note\">This report has no 3-D view: the program that wrote it was built "
           "without Node.js.</p>\n";
  }
  return "<div id=\"viewer\"></div>\n<noscript><p class=\"note\">The 3-D view needs JavaScript. "
         "Everything else on this page does without.</p></noscript>\n";
}

std::string ViewerScriptsHtml(const ReportData& data, const ViewerInput& input) {
  if (!HasScene(data, input) || input.script.empty()) return "";
  const ViewerBox box = ChooseViewerBox(input.sample, data.Positions());
  const ViewerPoints points = PackViewerPoints(data, input, box);
  return "<script type=\"application/json\" id=\"viewer-scene\">" +
         ForScript(SceneJson(data, input, box, points)) +
         "</script>\n<script type=\"application/octet-stream\" id=\"viewer-points\">" +
         Base64(Deflate(points.columns, kViewerCompression)) +
         "</script>\n<script type=\"module\">\n" + std::string(input.script) + "</script>\n";
}

}  // namespace planegraph
