#include <algorithm>
#include <map>

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
  if (TextAt(registration, {"kind"}) == "laser-map") return "em";  // another scale of residuals
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

// A node of the graph as it is drawn.
struct Node {
  Eigen::Vector2d at;
  std::ptrdiff_t order;  ///< of scans; nodes that follow each other are joined by a line
};

struct Nodes {
  std::map<std::string, Node> scans, maps;

  // Either may have the name: a map first, where the edge is one to a map.
  const Node* Find(const std::string& id, bool map) const {
    const auto& list = map ? maps : scans;
    const auto found = list.find(id);
    return found == list.end() ? nullptr : &found->second;
  }
};

// Where on the frame's margin a node is farthest from those that are there.
Eigen::Vector2d FreePlace(const PlanFrame& frame, const std::vector<Eigen::Vector2d>& taken) {
  constexpr double kInset = 34;
  const Eigen::Vector2d low(PlanFrame::kLeft + kInset, PlanFrame::kTop + kInset);
  const Eigen::Vector2d size(frame.width() - 2 * kInset, frame.height() - 2 * kInset);
  Eigen::Vector2d best = low;
  double farthest = -1.0;
  for (const double y : {0.0, 1.0, 0.5}) {
    for (const double x : {0.5, 0.25, 0.75, 0.0, 1.0}) {
      const Eigen::Vector2d place = low + size.cwiseProduct(Eigen::Vector2d(x, y));
      double nearest = 1e9;
      for (const Eigen::Vector2d& other : taken) {
        nearest = std::min(nearest, (other - place).norm());
      }
      // Beyond some room the middle of an edge is as good as a corner.
      nearest = std::min(nearest, 0.35 * frame.height());
      if (nearest > farthest) farthest = nearest, best = place;
    }
  }
  return best;
}

Nodes PlaceNodes(const ReportData& data, const PlanFrame& frame) {
  Nodes nodes;
  std::vector<Eigen::Vector2d> taken;
  for (std::size_t i = 0; i < data.scans.size(); ++i) {
    if (!data.scans[i].position) continue;
    taken.push_back(frame.Place(*data.scans[i].position));
    nodes.scans.insert({data.scans[i].id, {taken.back(), static_cast<std::ptrdiff_t>(i)}});
  }
  for (const ReportMap& map : data.maps) {
    taken.push_back(FreePlace(frame, taken));
    nodes.maps.insert({map.id, {taken.back(), -1}});
  }
  return nodes;
}

// Scans that follow each other, and a scan and a map, are joined by a line, others by an arc: edges
// along one line stay apart.
std::string EdgePath(const Node& source, const Node& target, bool map) {
  constexpr double kBend = 0.13;
  const bool straight = map || std::abs(source.order - target.order) <= 1;
  const Eigen::Vector2d along = target.at - source.at;
  const double side = source.order < target.order ? 1.0 : -1.0;
  const Eigen::Vector2d middle =
      (source.at + target.at) / 2 +
      (straight ? 0.0 : side * kBend) * Eigen::Vector2d(-along.y(), along.x());
  return "M" + Fixed(source.at.x(), 1) + " " + Fixed(source.at.y(), 1) + "Q" +
         Fixed(middle.x(), 1) + " " + Fixed(middle.y(), 1) + " " + Fixed(target.at.x(), 1) + " " +
         Fixed(target.at.y(), 1);
}

std::string EdgesSvg(const ReportData& data, const Nodes& nodes, bool used) {
  std::string svg;
  const Json& registrations = ListAt(*data.json, {"registrations"});
  for (std::size_t i = 0; i < registrations.size(); ++i) {
    const Json& r = registrations[i];
    if (FlagAt(r, {"used"}).value_or(false) != used) continue;
    const bool map = TextAt(r, {"kind"}) == "laser-map";
    const Node* target = nodes.Find(TextAt(r, {"target"}), map);
    const Node* source = nodes.Find(TextAt(r, {"source"}), false);
    if (!target || !source) continue;
    svg += "<path class=\"edge " + EdgeClass(r) + "\" data-registration=\"" + std::to_string(i) +
           "\" d=\"" + EdgePath(*source, *target, map) + "\"><title>" + Escape(EdgeTitle(r)) +
           "</title></path>\n";
  }
  return svg;
}

std::string MapNodesSvg(const Nodes& nodes, const PlanFrame& frame) {
  std::string svg;
  for (const auto& [id, node] : nodes.maps) {
    const bool left = node.at.x() < PlanFrame::kLeft + frame.width() / 2;
    svg +=
        "<rect class=\"drone\" x=\"-7\" y=\"-7\" width=\"14\" height=\"14\" "
        "transform=\"translate(" +
        Fixed(node.at.x(), 1) + " " + Fixed(node.at.y(), 1) + ") rotate(45)\"><title>" +
        Escape(id) + "</title></rect>\n";
    svg += SvgText(node.at + Eigen::Vector2d(left ? 15 : -15, 4),
                   left ? " class=\"label\"" : " class=\"label\" text-anchor=\"end\"", id);
  }
  return svg;
}

std::string EdgeKey(const std::string& style, const std::string& text) {
  return LegendItem("<path class=\"edge " + style + "\" d=\"M1 7H27\"/>", text);
}

std::string GraphLegend(const ReportData& data) {
  const bool has_maps = !data.maps.empty();
  const std::string map = LegendItem(
      "<rect class=\"drone\" x=\"9\" y=\"2\" width=\"10\" height=\"10\" "
      "transform=\"rotate(45 14 7)\"/>",
      "drone map (placed where there is room)");
  return "<ul class=\"legend\">" + (has_maps ? map + EdgeKey("em", "used, to a drone map") : "") +
         EdgeKey("e0",
                 has_maps ? "between scans, residual up to 5 mm" : "used, residual up to 5 mm") +
         EdgeKey("e1", "up to 10 mm") + EdgeKey("e2", "up to 20 mm") + EdgeKey("e3", "above") +
         EdgeKey("unused", "tried and not used") + ApartKey(data) + "</ul>\n";
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
  const Nodes nodes = PlaceNodes(data, frame);
  const std::string unused = EdgesSvg(data, nodes, false), used = EdgesSvg(data, nodes, true);
  if (unused.empty() && used.empty()) return "";
  return SvgOpen(frame, "The registrations of the scans") +
         SvgClip(frame, "graph-frame", MapUnder(plan, frame)) + SvgAxes(frame) + unused + used +
         MarksSvg(data, frame) + MapNodesSvg(nodes, frame) + SvgClose() + GraphLegend(data);
}

}  // namespace planegraph
