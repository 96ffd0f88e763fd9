#pragma once

#include <string>

#include "report/plan_svg.h"
#include "report/report_data.h"

namespace planegraph {

/// The class that carries a robot's colour.
std::string RobotClass(std::size_t robot);

/// The scans' positions as dots with their numbers, where there is room for these.
std::string MarksSvg(const ReportData& data, const PlanFrame& frame);

/// The legend's entry of the hollow dots; empty where no scan stands apart.
std::string ApartKey(const ReportData& data);

/// An entry of a legend: `swatch` is SVG in a box of 28 x 14, `text` HTML.
std::string LegendItem(const std::string& swatch, const std::string& text);

}  // namespace planegraph
