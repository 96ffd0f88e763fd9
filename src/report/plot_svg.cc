#include "report/plot_svg.h"

#include <algorithm>
#include <cmath>

#include "report/html.h"
#include "report/svg.h"

namespace planegraph {
namespace {

constexpr double kWidth = 560, kHeight = 190;  ///< of the drawing, units
constexpr double kLeft = 64, kTop = 22, kRight = 14, kBottom = 38;

struct Axes {
  double x_low = 0.0, x_high = 1.0, y_low = 0.0, y_high = 1.0;
  double y_step = 1.0;  ///< between the lines of the grid, where it is not logarithmic
  bool logarithmic = false;

  double Scaled(double y) const { return logarithmic ? std::log10(y) : y; }
  Eigen::Vector2d Place(double x, double y) const {
    return {kLeft + kWidth * (x - x_low) / (x_high - x_low),
            kTop + kHeight * (1.0 - (Scaled(y) - y_low) / (y_high - y_low))};
  }
};

bool IsPlain(double value) { return std::isfinite(value) && std::abs(value) < 1e30; }

Axes Fit(const std::vector<PlotLine>& lines, bool logarithmic) {
  Axes axes;
  double low = 1e300, high = -1e300, first = 1e300, last = -1e300;
  for (const PlotLine& line : lines) {
    for (const double value : line.values) {
      low = std::min(low, value);
      high = std::max(high, value);
    }
    first = std::min(first, line.first);
    last = std::max(last, line.first + static_cast<double>(line.values.size()) - 1.0);
  }
  constexpr double kLeastRatio = 5.0;  // below, a logarithmic axis has hardly a round number
  const bool positive = logarithmic && low > 1e-12;
  axes.logarithmic = positive && high > kLeastRatio * low;
  axes.x_low = first;
  axes.x_high = std::max(last, first + 1.0);
  axes.y_low = positive ? low - 0.1 * (high - low) : std::min(low, 0.0);
  if (axes.logarithmic) axes.y_low = std::log10(low) - 0.05;
  axes.y_high = axes.logarithmic ? std::log10(high) + 0.05 : high;
  if (!(axes.y_high - axes.y_low > 1e-12)) axes.y_high = axes.y_low + 1.0;
  // The uppermost line of the grid lies on or above the largest value.
  axes.y_step = RoundDown125((axes.y_high - axes.y_low) / 3.0);
  if (!axes.logarithmic) axes.y_high = axes.y_step * std::ceil(axes.y_high / axes.y_step);
  return axes;
}

// Equally many decimals at each line of a linear axis: those of the step.
std::string TickText(const Axes& axes, double value) {
  if (axes.logarithmic) return Significant(value, 2);
  return Fixed(value, std::max(0, static_cast<int>(-std::floor(std::log10(axes.y_step)))));
}

std::string TickSvg(const Axes& axes, double value) {
  const double y = axes.Place(axes.x_low, value).y();
  return SvgLine({kLeft, y}, {kLeft + kWidth, y}, " class=\"grid\"") +
         SvgText({kLeft - 6, y + 4}, " class=\"tick\" text-anchor=\"end\"", TickText(axes, value));
}

std::string UpSvg(const Axes& axes) {
  std::string svg;
  if (axes.logarithmic) {
    const double span = axes.y_high - axes.y_low;
    for (double power = std::floor(axes.y_low); power <= axes.y_high; ++power) {
      for (const double factor : {1.0, 2.0, 5.0}) {
        const double value = factor * std::pow(10.0, power);
        const bool inside = axes.Scaled(value) >= axes.y_low && axes.Scaled(value) <= axes.y_high;
        if (inside && (factor == 1.0 || span < 1.5)) svg += TickSvg(axes, value);
      }
    }
    return svg;
  }
  const double step = axes.y_step;
  for (double k = std::ceil(axes.y_low / step); k * step <= axes.y_high + 1e-6 * step; ++k) {
    svg += TickSvg(axes, k * step);
  }
  return svg;
}

std::string AcrossSvg(const Axes& axes) {
  std::string svg;
  const double step = std::max(1.0, RoundDown125((axes.x_high - axes.x_low) / 6.0));
  for (double k = std::ceil(axes.x_low / step); k * step <= axes.x_high; ++k) {
    const double x = kLeft + kWidth * (k * step - axes.x_low) / (axes.x_high - axes.x_low);
    svg += SvgText({x, kTop + kHeight + 16}, " class=\"tick\" text-anchor=\"middle\"",
                   Fixed(k * step, 0));
  }
  return svg;
}

std::string LineSvg(const Axes& axes, const PlotLine& line) {
  std::vector<Eigen::Vector2d> way;
  std::string marks;
  for (std::size_t i = 0; i < line.values.size(); ++i) {
    way.push_back(axes.Place(line.first + static_cast<double>(i), line.values[i]));
    marks += "<circle class=\"scan " + line.style + "\"" + SvgNumber("cx", way.back().x()) +
             SvgNumber("cy", way.back().y()) + " r=\"3\"><title>" + Significant(line.values[i], 4) +
             "</title></circle>\n";
  }
  return SvgPolyline(way, " class=\"way " + line.style + "\"") + marks;
}

}  // namespace

std::string PlotHtml(const std::vector<PlotLine>& lines, const PlotText& text, bool logarithmic) {
  std::vector<PlotLine> plain = lines;
  for (PlotLine& line : plain) {
    std::erase_if(line.values, [](double value) { return !IsPlain(value); });
  }
  std::erase_if(plain, [](const PlotLine& line) { return line.values.empty(); });
  if (plain.empty()) return "";
  const Axes axes = Fit(plain, logarithmic);
  std::string svg = "<div class=\"scroll\"><svg class=\"plot\" role=\"img\" aria-label=\"" +
                    Escape(text.label) + "\" viewBox=\"0 0 " + Fixed(kLeft + kWidth + kRight, 0) +
                    " " + Fixed(kTop + kHeight + kBottom, 0) + "\">\n" + UpSvg(axes) +
                    AcrossSvg(axes);
  for (const PlotLine& line : plain) svg += LineSvg(axes, line);
  return svg + SvgText({kLeft, 14}, " class=\"tick\"", text.up) +
         SvgText({kLeft + kWidth, kTop + kHeight + 32}, " class=\"tick\" text-anchor=\"end\"",
                 text.across) +
         "</svg></div>\n";
}

}  // namespace planegraph
