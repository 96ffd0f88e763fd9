#include "report/marks_svg.h"

#include <algorithm>

#include "report/html.h"
#include "report/svg.h"

namespace planegraph {
namespace {

constexpr std::size_t kMostNumbers = 60;  ///< of scans that a picture shows

std::string ScanMark(const ReportScan& scan, std::size_t index, const PlanFrame& frame) {
  const Eigen::Vector2d at = frame.Place(*scan.position);
  return "<circle class=\"scan " + RobotClass(scan.robot_index) +
         (scan.stands_apart ? " apart" : "") + "\" data-scan=\"" + std::to_string(index) + "\"" +
         SvgNumber("cx", at.x()) + SvgNumber("cy", at.y()) + " r=\"4.5\"><title>" +
         Escape(scan.id) + "</title></circle>\n";
}

// Numbers without leading zeros: they say the same in less room.
std::string ShortNumber(const std::string& number) {
  const std::size_t first = number.find_first_not_of('0');
  return first == std::string::npos ? (number.empty() ? "" : "0") : number.substr(first);
}

// Every number where there is room, else every k-th; none over another.
std::string ScanNumbers(const ReportData& data, const PlanFrame& frame) {
  constexpr double kRoom = 15;
  std::string svg;
  std::vector<Eigen::Vector2d> taken;
  const std::size_t every = 1 + data.scans.size() / (kMostNumbers + 1);
  for (std::size_t i = 0; i < data.scans.size(); i += every) {
    const ReportScan& scan = data.scans[i];
    if (!scan.position) continue;
    const Eigen::Vector2d at = frame.Place(*scan.position) + Eigen::Vector2d(7, -6);
    const bool free = std::none_of(taken.begin(), taken.end(), [&](const Eigen::Vector2d& other) {
      return (other - at).norm() < kRoom;
    });
    if (!free) continue;
    taken.push_back(at);
    svg += SvgText(at, " class=\"label\"", ShortNumber(scan.number));
  }
  return svg;
}

}  // namespace

std::string RobotClass(std::size_t robot) { return "r" + std::to_string(robot % 6); }

std::string MarksSvg(const ReportData& data, const PlanFrame& frame) {
  std::string map, apart;
  for (std::size_t i = 0; i < data.scans.size(); ++i) {
    const ReportScan& scan = data.scans[i];
    if (scan.position) (scan.stands_apart ? apart : map) += ScanMark(scan, i, frame);
  }
  return apart + map + ScanNumbers(data, frame);
}

std::string ApartKey(const ReportData& data) {
  if (data.is_whole) return "";
  return LegendItem("<circle class=\"scan apart r0\" cx=\"14\" cy=\"7\" r=\"4.5\"/>",
                    std::string("scans that stand apart") +
                        (ApartPlacedByNothing(data) ? ": their place means nothing" : ""));
}

std::string LegendItem(const std::string& swatch, const std::string& text) {
  return "<li><svg class=\"key\" viewBox=\"0 0 28 14\">" + swatch + "</svg>" + text + "</li>";
}

}  // namespace planegraph
