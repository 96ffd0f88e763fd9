#include <algorithm>

#include "report/html.h"
#include "report/marks_svg.h"
#include "report/plan_svg.h"
#include "report/svg.h"

namespace planegraph {
namespace {

// Classes of residuals, metres: `e0` is the best.
constexpr double kResidualLimits[] = {0.005, 0.010, 0.020};

std::string EdgeClass(const Json& registration) {
  if (!FlagAt(registration, {"used"}).value_or(false)) return "unused";
  const auto rms = NumberAt(registration, {"rms"});
  if (!rms) return "e9";
  int k = 0;
  for (const double limit : kResidualLimits) k += *rms > limit ? 1 : 0;
  return "e" + std::to_string(k);
}

std::string EdgeTitle(const Json& r) {
  return TextAt(r, {"source"}) + " to " + TextAt(r, {"target"}) + ": " + TextAt(r, {"status"}) +
         ", residual " + FixedOrDash(NumberAt(r, {"rms"}), 1, 1000) + " mm";
}

// Scans that follow each other are joined by a line, others by an arc: edges along one line stay
// apart.
std::string EdgePath(const ReportScan& source, const ReportScan& target, const PlanFrame& frame) {
  constexpr double kBend = 0.13;
  const Eigen::Vector2d from = frame.Place(*source.position), to = frame.Place(*target.position);
  const bool neighbours = std::abs(&source - &target) <= 1;
  const Eigen::Vector2d along = to - from;
  const double side = &source < &target ? 1.0 : -1.0;
  const Eigen::Vector2d middle =
      (from + to) / 2 + (neighbours ? 0.0 : side * kBend) * Eigen::Vector2d(-along.y(), along.x());
  return "M" + Fixed(from.x(), 1) + " " + Fixed(from.y(), 1) + "Q" + Fixed(middle.x(), 1) + " " +
         Fixed(middle.y(), 1) + " " + Fixed(to.x(), 1) + " " + Fixed(to.y(), 1);
}

std::string EdgesSvg(const ReportData& data, const PlanFrame& frame, bool used) {
  std::string svg;
  for (const Json& r : ListAt(*data.json, {"registrations"})) {
    if (FlagAt(r, {"used"}).value_or(false) != used) continue;
    const ReportScan* target = data.Find(TextAt(r, {"target"}));
    const ReportScan* source = data.Find(TextAt(r, {"source"}));
    if (!target || !source || !target->position || !source->position) continue;
    svg += "<path class=\"edge " + EdgeClass(r) + "\" d=\"" + EdgePath(*source, *target, frame) +
           "\"><title>" + Escape(EdgeTitle(r)) + "</title></path>\n";
  }
  return svg;
}

std::string EdgeKey(const std::string& style, const std::string& text) {
  return LegendItem("<path class=\"edge " + style + "\" d=\"M1 7H27\"/>", text);
}

std::string GraphLegend() {
  return "<ul class=\"legend\">" + EdgeKey("e0", "used, residual up to 5 mm") +
         EdgeKey("e1", "up to 10 mm") + EdgeKey("e2", "up to 20 mm") + EdgeKey("e3", "above") +
         EdgeKey("unused", "tried and not used") + "</ul>\n";
}

// The scans alone, with some room around them.
PlanView ViewOfScans(const ReportData& data, const PlanView& plan) {
  constexpr double kMargin = 0.06, kFlattest = 0.3, kLeastShare = 0.4;
  PlanView view = plan;
  const auto positions = data.Positions();
  if (positions.empty()) return view;
  view.low = view.high = plan.OnPage(positions.front().head<2>());
  for (const Eigen::Vector3d& p : positions) {
    view.low = view.low.cwiseMin(plan.OnPage(p.head<2>()));
    view.high = view.high.cwiseMax(plan.OnPage(p.head<2>()));
  }
  const double longest =
      std::max({view.Extent().maxCoeff(), kLeastShare * plan.Extent().maxCoeff(), 1.0});
  Eigen::Index wide = 0;
  view.Extent().maxCoeff(&wide);
  Eigen::Array2d least = Eigen::Array2d::Constant(kFlattest * longest);
  least[wide] = longest;
  const Eigen::Vector2d margin = kMargin * longest + (least - view.Extent().array()).max(0.0) / 2.0;
  view.low -= margin;
  view.high += margin;
  return view;
}

// The map's picture of the plan, moved to where it belongs in `frame`.
std::string MapUnder(const PlanFrame& plan, const PlanFrame& frame) {
  const double zoom = frame.scale() / plan.scale();
  const Eigen::Vector2d corner = plan.PlacePage(plan.view().low);
  const Eigen::Vector2d shift = frame.PlacePage(plan.view().low) - zoom * corner;
  return "<g opacity=\"0.25\"><use href=\"#map\" transform=\"translate(" + Fixed(shift.x(), 2) +
         " " + Fixed(shift.y(), 2) + ") scale(" + Fixed(zoom, 5) + ")\"/></g>\n";
}

}  // namespace

std::string GraphHtml(const ReportData& data, const PlanFrame& plan) {
  constexpr double kHeight = 560;
  const PlanFrame frame(ViewOfScans(data, plan.view()), kHeight);
  const std::string unused = EdgesSvg(data, frame, false), used = EdgesSvg(data, frame, true);
  if (unused.empty() && used.empty()) return "";
  return SvgOpen(frame, "The registrations between the scans") +
         SvgClip(frame, "graph-frame", MapUnder(plan, frame)) + SvgAxes(frame) + unused + used +
         MarksSvg(data, frame) + SvgClose() + GraphLegend();
}

}  // namespace planegraph
