#include "report/plan_svg.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

#include "report/drone_photo.h"
#include "report/html.h"
#include "report/marks_svg.h"
#include "report/svg.h"

namespace planegraph {
namespace {

constexpr double kMostWidth = 1140;  ///< units

// ---- uncertainty ----

// The horizontal part of a position's covariance, as half axes in metres; nothing where infinite.
struct Ellipse {
  Eigen::Vector2d half_axes;  ///< smaller first
  double angle = 0.0;         ///< of the longer one on the page, degrees, SVG's sense
};

std::optional<Ellipse> EllipseOf(const ReportScan& scan, const PlanView& view) {
  if (!scan.covariance || !scan.position) return std::nullopt;
  const Eigen::Matrix2d block = scan.covariance->topLeftCorner<2, 2>();
  if (!block.allFinite()) return std::nullopt;
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> solver(block);
  const Eigen::Vector2d longest = view.OnPage(solver.eigenvectors().col(1));
  return Ellipse{solver.eigenvalues().cwiseMax(0.0).cwiseSqrt(),
                 -std::atan2(longest.y(), longest.x()) * 180.0 / M_PI};
}

// A round factor that makes the middle one of the ellipses a little larger than a scan's mark; 0
// where there is none.
double Exaggeration(const ReportData& data, const PlanFrame& frame) {
  constexpr double kUnits = 18;
  std::vector<double> sigmas;
  for (const ReportScan& scan : data.scans) {
    const auto ellipse = EllipseOf(scan, frame.view());
    if (ellipse && ellipse->half_axes.y() > 0) sigmas.push_back(ellipse->half_axes.y());
  }
  if (sigmas.empty()) return 0.0;
  const auto middle = sigmas.begin() + static_cast<std::ptrdiff_t>(sigmas.size() / 2);
  std::nth_element(sigmas.begin(), middle, sigmas.end());
  return std::max(1.0, RoundDown125(kUnits / (*middle * frame.scale())));
}

std::string EllipseSvg(const ReportScan& scan, const PlanFrame& frame, double factor) {
  const auto ellipse = EllipseOf(scan, frame.view());
  if (!ellipse || ellipse->half_axes.y() <= 0) return "";
  const Eigen::Vector2d at = frame.Place(*scan.position);
  const Eigen::Vector2d radii =
      (ellipse->half_axes * factor * frame.scale()).cwiseMax(0.7).cwiseMin(3.0 * frame.width());
  return "<ellipse class=\"sigma " + RobotClass(scan.robot_index) + "\"" +
         SvgNumber("rx", radii.y()) + SvgNumber("ry", radii.x()) + " transform=\"translate(" +
         Fixed(at.x(), 1) + " " + Fixed(at.y(), 1) + ") rotate(" + Fixed(ellipse->angle, 1) +
         ")\"/>\n";
}

// A dashed line through the scan along each horizontal translation that the planes leave open.
std::string OpenDirectionsSvg(const ReportScan& scan, const PlanFrame& frame) {
  constexpr double kHalfLength = 24;
  std::string svg;
  for (const OpenDirection& open : OpenDirections(*scan.json)) {
    if (open.is_rotation || !scan.position) continue;
    const Eigen::Vector2d page = frame.view().OnPage(open.axis.head<2>());
    if (page.norm() < 0.5) continue;
    const Eigen::Vector2d at = frame.Place(*scan.position);
    const Eigen::Vector2d reach = kHalfLength * Eigen::Vector2d(page.x(), -page.y());
    svg += SvgLine(at - reach, at + reach, " class=\"open\"");
  }
  return svg;
}

// ---- scans ----

// Scans of a robot, one after another.
using Way = std::vector<const ReportScan*>;

// A robot's way, cut where the component changes: between components no step is known.
std::vector<Way> WaysOf(const ReportData& data, std::size_t robot) {
  std::vector<Way> ways;
  for (const ReportScan& scan : data.scans) {
    if (scan.robot_index != robot || !scan.position) continue;
    if (ways.empty() || ways.back().back()->component != scan.component) ways.emplace_back();
    ways.back().push_back(&scan);
  }
  return ways;
}

std::string WaySvg(const Way& way, const PlanFrame& frame) {
  if (way.size() < 2) return "";
  std::vector<Eigen::Vector2d> places;
  for (const ReportScan* scan : way) places.push_back(frame.Place(*scan->position));
  const std::string apart = way[0]->stands_apart ? " apart" : "";
  return SvgPolyline(places, " class=\"halo\"") +
         SvgPolyline(places, " class=\"way " + RobotClass(way[0]->robot_index) + apart + "\"");
}

std::string WaysSvg(const ReportData& data, const PlanFrame& frame) {
  std::string svg;
  for (std::size_t robot = 0; robot < data.robots.size(); ++robot) {
    for (const Way& way : WaysOf(data, robot)) svg += WaySvg(way, frame);
  }
  return svg;
}

// ---- the map's picture ----

// A picture whose pixels are `pixel` metres wide and begin at the lower left of the view: the last
// row and column may reach over it by part of a pixel.
std::string ImageSvg(const IndexedImage& image, const std::vector<Rgba>& palette, double pixel,
                     const PlanFrame& frame) {
  const double units = pixel * frame.scale();
  const double height = units * static_cast<double>(image.height);
  return "<image" + SvgNumber("x", PlanFrame::kLeft) +
         SvgNumber("y", PlanFrame::kTop + frame.height() - height) +
         SvgNumber("width", units * static_cast<double>(image.width)) +
         SvgNumber("height", height) +
         " preserveAspectRatio=\"none\" href=\"data:image/png;base64," +
         Base64(EncodePng(image, palette)) + "\"/>";
}

std::string PhotoSvg(const Cloud& drone, const PlanFrame& frame) {
  const DronePhoto photo = DrawDronePhoto(drone, frame.view());
  if (photo.palette.empty()) return "";
  return "<g class=\"photo\">" + ImageSvg(photo.image, photo.palette, photo.pixel, frame) +
         "</g>\n";
}

std::string LaserSvg(const Cloud& laser, const PlanFrame& frame) {
  if (laser.points.empty()) return "";
  const FloorPlan plan = DrawFloorPlan(laser, frame.view());
  return "<g class=\"map\">" + ImageSvg(plan.image, plan.palette, PlanPixel(frame.view()), frame) +
         "</g>\n";
}

struct Pictures {
  std::string photo, laser;  // SVG; empty where there are no points

  std::string Svg() const { return "<g id=\"map\">" + photo + laser + "</g>\n"; }
};

// ---- legend ----

std::string MapKey(const std::string& style, const std::string& text) {
  return LegendItem("<rect class=\"" + style + "\" x=\"4\" y=\"2\" width=\"20\" height=\"10\"/>",
                    text);
}

std::string PlanLegend(const ReportData& data, const Pictures& pictures, bool has_open,
                       double factor) {
  std::string items;
  for (std::size_t robot = 0; robot < data.robots.size(); ++robot) {
    const std::string style = RobotClass(robot);
    items += LegendItem("<path class=\"way " + style + "\" d=\"M1 7H27\"/><circle class=\"scan " +
                            style + "\" cx=\"14\" cy=\"7\" r=\"4.5\"/>",
                        "scans of " + TextOrDash(data.robots[robot]) + " and their numbers");
  }
  items += ApartKey(data);
  if (!pictures.photo.empty()) items += MapKey("photo-key", Escape("the drone's map from above"));
  if (!pictures.laser.empty()) {
    items += MapKey("upright", "upright, 0.3 to 1.8 m above the ground") +
             MapKey("high", "upright, above 1.8 m only") + MapKey("seen", "floor or ceiling seen");
  }
  if (factor > 0) {
    items += LegendItem("<ellipse class=\"sigma r0\" cx=\"14\" cy=\"7\" rx=\"12\" ry=\"5\"/>",
                        "1-sigma ellipse of the position" +
                            (factor > 1 ? ", drawn " + Grouped(factor) + " times its size" : ""));
  }
  if (has_open)
    items += LegendItem("<path class=\"open\" d=\"M1 7H27\"/>",
                        "translation that the planes leave open");
  return "<ul class=\"legend\">" + items + "</ul>\n";
}

}  // namespace

PlanFrame::PlanFrame(const PlanView& view, double most_height) : view_(view) {
  const Eigen::Vector2d extent = view.Extent();
  scale_ = std::min(kMostWidth / extent.x(), most_height / extent.y());
  width_ = extent.x() * scale_;
  height_ = extent.y() * scale_;
}

std::string FloorPlanHtml(const ReportData& data, const MergedMap& map, const PlanFrame& frame) {
  if (data.Positions().empty() && map.laser.points.empty()) return "";
  const Pictures pictures{PhotoSvg(map.vision, frame), LaserSvg(map.laser, frame)};
  const double factor = Exaggeration(data, frame);
  std::string ellipses, open;
  for (const ReportScan& scan : data.scans) {
    ellipses += EllipseSvg(scan, frame, factor);
    open += OpenDirectionsSvg(scan, frame);
  }
  return SvgOpen(frame, "The map from above with the scans' positions") +
         SvgClip(frame, "plan-frame", pictures.Svg()) + SvgAxes(frame) +
         SvgClip(frame, "plan-marks",
                 ellipses + WaysSvg(data, frame) + open + MarksSvg(data, frame)) +
         SvgClose() + PlanLegend(data, pictures, !open.empty(), factor);
}

}  // namespace planegraph
