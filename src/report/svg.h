#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "report/plan_svg.h"

namespace planegraph {

/// ` name="value"` with one decimal, which is finer than a pixel.
std::string SvgNumber(const char* name, double value);
std::string SvgLine(const Eigen::Vector2d& from, const Eigen::Vector2d& to,
                    const std::string& attributes);
std::string SvgText(const Eigen::Vector2d& at, const std::string& attributes,
                    const std::string& text);
std::string SvgPolyline(const std::vector<Eigen::Vector2d>& points, const std::string& attributes);

/// Opens and closes a picture of the frame's size; `label` describes it to those who cannot see it.
std::string SvgOpen(const PlanFrame& frame, const std::string& label);
inline std::string SvgClose() { return "</svg></div>\n"; }

/// `content`, cut off at the frame; `id` is the cut's and unique on the page.
std::string SvgClip(const PlanFrame& frame, const std::string& id, const std::string& content);

/// Grid, labelled axes, border and a scale bar.
std::string SvgAxes(const PlanFrame& frame);

/// The nearest of 1, 2, 5 times a power of ten that is not above `value`.
double RoundDown125(double value);

}  // namespace planegraph
