#include "report/svg.h"

#include <cmath>

#include "report/html.h"

namespace planegraph {
namespace {

// Decimals that tell neighbouring ticks apart.
int TickDecimals(double step) { return step >= 1.0 ? 0 : step >= 0.1 ? 1 : 2; }

std::string VerticalTicks(const PlanFrame& frame, double step) {
  const PlanView& view = frame.view();
  std::string svg;
  for (double k = std::ceil(view.low.x() / step); k * step <= view.high.x(); ++k) {
    const double x = frame.PlacePage({k * step, view.low.y()}).x();
    const double bottom = PlanFrame::kTop + frame.height();
    svg += SvgLine({x, PlanFrame::kTop}, {x, bottom}, " class=\"grid\"");
    const double value = view.turned ? -k * step : k * step;
    svg += SvgText({x, bottom + 17}, " class=\"tick\" text-anchor=\"middle\"",
                   Fixed(value, TickDecimals(step)));
  }
  return svg;
}

std::string HorizontalTicks(const PlanFrame& frame, double step) {
  const PlanView& view = frame.view();
  std::string svg;
  for (double k = std::ceil(view.low.y() / step); k * step <= view.high.y(); ++k) {
    const double y = frame.PlacePage({view.low.x(), k * step}).y();
    svg += SvgLine({PlanFrame::kLeft, y}, {PlanFrame::kLeft + frame.width(), y}, " class=\"grid\"");
    svg += SvgText({PlanFrame::kLeft - 6, y + 4}, " class=\"tick\" text-anchor=\"end\"",
                   Fixed(k * step, TickDecimals(step)));
  }
  return svg;
}

// In the lower right corner, over the map.
std::string ScaleBar(const PlanFrame& frame) {
  const double length = RoundDown125(frame.width() / frame.scale() / 5.0);
  const double right = PlanFrame::kLeft + frame.width() - 14;
  const double left = right - length * frame.scale();
  const double y = PlanFrame::kTop + frame.height() - 14;
  const std::string bar =
      "M" + Fixed(left, 1) + " " + Fixed(y - 5, 1) + "v5H" + Fixed(right, 1) + "v-5";
  return "<path class=\"halo\" d=\"" + bar + "\"/><path class=\"bar\" d=\"" + bar + "\"/>" +
         SvgText({(left + right) / 2, y - 7}, " class=\"label\" text-anchor=\"middle\"",
                 Fixed(length, TickDecimals(length)) + " m");
}

std::string AxisNames(const PlanFrame& frame) {
  const double bottom = PlanFrame::kTop + frame.height();
  const bool turned = frame.view().turned, north_up = frame.view().north_up;
  const char* across = turned ? "← y [m]" : north_up ? "x, east [m] →" : "x [m] →";
  const char* up = turned ? "x [m] ↑" : north_up ? "y, north [m] ↑" : "y [m] ↑";
  return SvgText({PlanFrame::kLeft + 6, bottom - 8}, " class=\"label\"", across) +
         SvgText({PlanFrame::kLeft + 6, PlanFrame::kTop + 18}, " class=\"label\"", up);
}

}  // namespace

std::string SvgNumber(const char* name, double value) {
  return std::string(" ") + name + "=\"" + Fixed(value, 1) + "\"";
}

std::string SvgLine(const Eigen::Vector2d& from, const Eigen::Vector2d& to,
                    const std::string& attributes) {
  return "<line" + SvgNumber("x1", from.x()) + SvgNumber("y1", from.y()) + SvgNumber("x2", to.x()) +
         SvgNumber("y2", to.y()) + attributes + "/>\n";
}

std::string SvgText(const Eigen::Vector2d& at, const std::string& attributes,
                    const std::string& text) {
  return "<text" + SvgNumber("x", at.x()) + SvgNumber("y", at.y()) + attributes + ">" +
         Escape(text) + "</text>\n";
}

std::string SvgPolyline(const std::vector<Eigen::Vector2d>& points, const std::string& attributes) {
  std::string list;
  for (const Eigen::Vector2d& p : points) {
    list += (list.empty() ? "" : " ") + Fixed(p.x(), 1) + "," + Fixed(p.y(), 1);
  }
  return "<polyline points=\"" + list + "\"" + attributes + "/>\n";
}

std::string SvgOpen(const PlanFrame& frame, const std::string& label) {
  const double width = PlanFrame::kLeft + frame.width() + PlanFrame::kRight;
  const double height = PlanFrame::kTop + frame.height() + PlanFrame::kBottom;
  return "<div class=\"scroll\"><svg class=\"plan\" role=\"img\" aria-label=\"" + Escape(label) +
         "\" viewBox=\"0 0 " + Fixed(width, 1) + " " + Fixed(height, 1) +
         "\" style=\"--w:" + Fixed(1.04 * width, 0) + "\">\n";
}

std::string SvgClip(const PlanFrame& frame, const std::string& id, const std::string& content) {
  return "<defs><clipPath id=\"" + id + "\"><rect" + SvgNumber("x", PlanFrame::kLeft) +
         SvgNumber("y", PlanFrame::kTop) + SvgNumber("width", frame.width()) +
         SvgNumber("height", frame.height()) + "/></clipPath></defs>\n<g clip-path=\"url(#" + id +
         ")\">\n" + content + "</g>\n";
}

std::string SvgAxes(const PlanFrame& frame) {
  const double longest = std::max(frame.width(), frame.height()) / frame.scale();
  const double step = RoundDown125(longest / 8.0);
  return VerticalTicks(frame, step) + HorizontalTicks(frame, step) + "<rect class=\"border\"" +
         SvgNumber("x", PlanFrame::kLeft) + SvgNumber("y", PlanFrame::kTop) +
         SvgNumber("width", frame.width()) + SvgNumber("height", frame.height()) + "/>\n" +
         AxisNames(frame) + ScaleBar(frame);
}

double RoundDown125(double value) {
  const double power = std::pow(10.0, std::floor(std::log10(value)));
  const double mantissa = value / power * (1.0 + 1e-9);
  return power * (mantissa >= 5.0 ? 5.0 : mantissa >= 2.0 ? 2.0 : 1.0);
}

}  // namespace planegraph
