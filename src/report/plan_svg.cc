#include "report/plan_svg.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

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

std::string WaysSvg(const ReportData& data, const PlanFrame& frame) {
  std::string svg;
  for (std::size_t robot = 0; robot < data.robots.size(); ++robot) {
    std::vector<Eigen::Vector2d> way;
    for (const ReportScan& scan : data.scans) {
      if (scan.robot_index == robot && scan.position) way.push_back(frame.Place(*scan.position));
    }
    if (way.size() < 2) continue;
    svg += SvgPolyline(way, " class=\"halo\"");
    svg += SvgPolyline(way, " class=\"way " + RobotClass(robot) + "\"");
  }
  return svg;
}

// ---- the map's picture ----

std::string MapSvg(const Cloud& map, const PlanFrame& frame) {
  if (map.points.empty()) return "<g id=\"map\"></g>\n";
  const FloorPlan plan = DrawFloorPlan(map, frame.view());
  // The picture's last row and column may reach over the view by part of a pixel.
  const Eigen::Vector2d page = frame.view().Extent();
  const double pixel = PlanPixel(frame.view()) * frame.scale();
  const double height = pixel * static_cast<double>(plan.image.height);
  return "<g id=\"map\" class=\"map\"><image" + SvgNumber("x", PlanFrame::kLeft) +
         SvgNumber("y", PlanFrame::kTop + page.y() * frame.scale() - height) +
         SvgNumber("width", pixel * static_cast<double>(plan.image.width)) +
         SvgNumber("height", height) +
         " preserveAspectRatio=\"none\" href=\"data:image/png;base64," +
         Base64(EncodePng(plan.image, plan.palette)) + "\"/></g>\n";
}

// ---- legend ----

std::string MapKey(const std::string& style, const std::string& text) {
  return LegendItem("<rect class=\"" + style + "\" x=\"4\" y=\"2\" width=\"20\" height=\"10\"/>",
                    text);
}

std::string PlanLegend(const ReportData& data, bool has_map, bool has_open, double factor) {
  std::string items;
  for (std::size_t robot = 0; robot < data.robots.size(); ++robot) {
    const std::string style = RobotClass(robot);
    items += LegendItem("<path class=\"way " + style + "\" d=\"M1 7H27\"/><circle class=\"scan " +
                            style + "\" cx=\"14\" cy=\"7\" r=\"4.5\"/>",
                        "scans of " + TextOrDash(data.robots[robot]) + " and their numbers");
  }
  if (has_map) {
    items += MapKey("upright", "upright, 0.3 to 1.8 m above the ground") +
             MapKey("high", "higher alone") + MapKey("seen", "seen");
  }
  if (factor > 0) {
    items +=
        LegendItem("<ellipse class=\"sigma r0\" cx=\"14\" cy=\"7\" rx=\"12\" ry=\"5\"/>",
                   "1-sigma ellipse of the position, drawn " + Grouped(factor) + " times its size");
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

std::string FloorPlanHtml(const ReportData& data, const Cloud& map, const PlanFrame& frame) {
  if (data.Positions().empty() && map.points.empty()) return "";
  const double factor = Exaggeration(data, frame);
  std::string ellipses, open;
  for (const ReportScan& scan : data.scans) {
    ellipses += EllipseSvg(scan, frame, factor);
    open += OpenDirectionsSvg(scan, frame);
  }
  return SvgOpen(frame, "The map from above with the scans' positions") +
         SvgClip(frame, "plan-frame", MapSvg(map, frame)) + SvgAxes(frame) +
         SvgClip(frame, "plan-marks",
                 ellipses + WaysSvg(data, frame) + open + MarksSvg(data, frame)) +
         SvgClose() + PlanLegend(data, !map.points.empty(), !open.empty(), factor);
}

}  // namespace planegraph
