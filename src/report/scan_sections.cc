#include <algorithm>
#include <cmath>
#include <set>

#include "planegraph/base/angles.h"
#include "report/html.h"
#include "report/sections.h"

namespace planegraph {
namespace {

// ---- open directions ----

std::string OpenItem(const ReportScan& scan, const OpenDirection& open) {
  const std::string what = open.sigma ? "not observed by the planes, " : "not observed, ";
  return "<li><b>" + TextOrDash(scan.id) + "</b>: " + InWords(open) + ": " + what +
         HoldInWords(open) + "</li>\n";
}

std::string OpenItems(const ReportData& data, std::size_t* count) {
  std::string items;
  for (const ReportScan& scan : data.scans) {
    for (const OpenDirection& open : OpenDirections(*scan.json)) {
      items += OpenItem(scan, open);
      ++*count;
    }
  }
  return items;
}

// The motions that the planes of the whole graph leave open, in words.
std::string OpenMotions(const Json& json) {
  std::string items;
  for (const Json& motion : ListAt(json, {"observability", "motions"})) {
    const std::string text = TextAt(motion, {"text"});
    if (!text.empty()) items += "<li>" + Escape(text) + "</li>\n";
  }
  return items.empty() ? "" : "<ul class=\"words\">\n" + items + "</ul>\n";
}

// How long the odometry's metre is: where it holds an open direction it is scaled by that.
std::string OdometryScales(const Json& json) {
  std::string items;
  const auto robots = json.find("odometry");
  if (robots == json.end() || !robots->is_object()) return items;
  for (const auto& [robot, found] : robots->items()) {
    const auto scale = NumberAt(found, {"scale"}), sigma = NumberAt(found, {"sigma_scale"});
    if (!scale || !sigma) continue;
    items += "<li>A metre of the odometry of " + Escape(robot) + " is " + Fixed(*scale, 4) +
             " \u00b1 " + Fixed(*sigma, 4) + "\u00a0m.</li>\n";
  }
  return items.empty() ? "" : "<ul class=\"words\">\n" + items + "</ul>\n";
}

std::string FoldedList(const std::string& items, std::size_t count, const std::string& summary,
                       std::size_t most_open) {
  if (count == 0) return "";
  std::string list = "<ul class=\"words\">\n" + items + "</ul>\n";
  if (count <= most_open) return list;
  return "<details><summary>" + Escape(summary) + "</summary>\n" + list + "</details>\n";
}

std::string WarningsHtml(const Json& json) {
  std::string items;
  for (const Json& warning : ListAt(json, {"warnings"})) {
    if (warning.is_string()) items += "<li>" + Escape(warning.get<std::string>()) + "</li>\n";
  }
  return items.empty() ? "" : "<ul class=\"words\">\n" + items + "</ul>\n";
}

// ---- scans ----

std::string PositionText(const ReportScan& scan) {
  if (!scan.position) return kDash;
  const Eigen::Vector3d& p = *scan.position;
  return Fixed(p.x(), 2) + ", " + Fixed(p.y(), 2) + ", " + Fixed(p.z(), 2);
}

// Nothing is known of its place; the others of its component are relative to it.
bool IsFirstApart(const ReportScan& scan) { return scan.stands_apart && IsFixed(scan); }

// Numbers of components begin with 1 for readers.
std::string ComponentText(const ReportScan& scan) {
  return scan.component ? std::to_string(*scan.component + 1) : kDash;
}

std::string SigmaText(const ReportScan& scan, int first, double factor, int decimals) {
  if (!scan.covariance || IsFirstApart(scan)) return kDash;
  return Fixed(WeakestAxis(*scan.covariance, first).sigma * factor, decimals);
}

// Covariances are relative to a fixed scan; where GPS holds all scans, there is none.
bool HasFixed(const ReportData& data) {
  return std::any_of(data.scans.begin(), data.scans.end(), IsFixed);
}

// The scans of which every used registration leaves directions open.
std::set<std::string> OnlyDegenerate(const Json& json) {
  std::set<std::string> degenerate, others;
  for (const Json& r : ListAt(json, {"registrations"})) {
    if (!FlagAt(r, {"used"}).value_or(false)) continue;
    auto& names = TextAt(r, {"status"}) == "degenerate" ? degenerate : others;
    names.insert({TextAt(r, {"target"}), TextAt(r, {"source"})});
  }
  std::erase_if(degenerate, [&](const std::string& name) { return others.count(name) > 0; });
  return degenerate;
}

// What the rows of the table of scans have in common.
struct ScanTable {
  bool has_fixed = false;
  std::set<std::string> only_degenerate;
};

// In the world's frame GPS has its share in every direction.
std::string PlanesHold(const ReportScan& scan, const ScanTable& all) {
  if (!all.has_fixed) return "";
  return all.only_degenerate.count(scan.id) == 0
             ? ", held by planes"
             : ", held by the planes of all scans: those of its own registrations leave some open";
}

std::string WeakestText(const ReportScan& scan, const ScanTable& all) {
  const auto open = OpenDirections(*scan.json);
  if (!open.empty()) return InWords(open.front()) + ", " + HoldInWords(open.front());
  if (IsFirstApart(scan)) return "first of component " + ComponentText(scan) + ": place unknown";
  if (IsFixed(scan)) return "fixed: the world's frame";
  if (!scan.covariance) return kDash;
  const Weakest weakest = WeakestAxis(*scan.covariance, 0);
  OpenDirection words;
  words.axis = weakest.axis;
  return InWords(words) + PlanesHold(scan, all);
}

// Where no row says what holds its direction, the heading does not promise it.
std::string WeakestHeading(const ReportData& data, bool has_fixed) {
  const bool any = std::any_of(data.scans.begin(), data.scans.end(), [](const ReportScan& scan) {
    return !OpenDirections(*scan.json).empty();
  });
  return has_fixed || any ? "weakest direction, and what holds it" : "weakest direction";
}

std::string SecondsText(const Json& scan) {
  double sum = 0.0;
  bool any = false;
  for (const char* step : {"read", "preprocess", "segment"}) {
    const auto seconds = NumberAt(scan, {"seconds", step});
    sum += seconds.value_or(0.0);
    any = any || seconds;
  }
  return any ? Fixed(sum, 3) : kDash;
}

std::string AnchorsText(const Json& scan) {
  std::string text;
  for (const std::string& name : AnchorsOf(scan)) text += (text.empty() ? "" : ", ") + Escape(name);
  return text.empty() ? kDash : text;
}

// What one registration between two scans knows of its weakest direction, in the middle of all that
// are used; nothing where there are none.
std::optional<double> SigmaBetweenScans(const Json& json) {
  std::vector<double> sigmas;
  for (const Json& r : ListAt(json, {"registrations"})) {
    if (!FlagAt(r, {"used"}).value_or(false) || TextAt(r, {"status"}) != "ok") continue;
    const auto covariance = CovarianceOf(r);
    if (!covariance || TextAt(r, {"kind"}) != "laser-laser") continue;
    sigmas.push_back(WeakestAxis(*covariance, 0).sigma);
  }
  if (sigmas.empty()) return std::nullopt;
  const auto middle = sigmas.begin() + static_cast<std::ptrdiff_t>(sigmas.size() / 2);
  std::nth_element(sigmas.begin(), middle, sigmas.end());
  return std::isfinite(*middle) ? std::optional(*middle) : std::nullopt;
}

// Half a metre beside each scan means the site's place on the earth, not the map's sharpness.
std::string WorldNote(const ReportData& data, bool has_fixed) {
  const bool by_gps = NumberAt(*data.json, {"origin", "lat"}).has_value();
  const bool any = std::any_of(data.scans.begin(), data.scans.end(),
                               [](const ReportScan& scan) { return scan.covariance.has_value(); });
  if (has_fixed || !by_gps || !any) return "";
  const auto sigma = SigmaBetweenScans(*data.json);
  return "<p class=\"note\">In the world frame: how well GPS places the whole site is part of "
         "sigma" +
         (sigma ? "; a registration by itself holds two scans to each other to about " +
                      Significant(1000.0 * *sigma, 2) + "\u00a0mm (median)"
                : "") +
         ".</p>\n";
}

std::string SigmaNote(const ReportData& data, bool has_fixed) {
  const std::string frame = !has_fixed      ? "in the world frame"
                            : data.is_whole ? "relative to the fixed scan"
                                            : "relative to the first scan of its component";
  return "<p class=\"note\">Sigma: of the position along its weakest direction, and of the "
         "rotation about its weakest axis, " +
         frame + ".</p>\n";
}

void AddScan(const ReportData& data, const ReportScan& scan, const ScanTable& all,
             HtmlTable* table) {
  const Json& json = *scan.json;
  std::vector<std::string> cells = {TextOrDash(scan.id),
                                    GroupedOrDash(NumberAt(json, {"points"})),
                                    GroupedOrDash(NumberAt(json, {"points_filtered"})),
                                    GroupedOrDash(NumberAt(json, {"planes"})),
                                    PositionText(scan),
                                    SigmaText(scan, 0, 1000.0, 1),
                                    SigmaText(scan, 3, kDegreesPerRadian, 3),
                                    SecondsText(json),
                                    WeakestText(scan, all)};
  if (!data.maps.empty()) cells.insert(cells.end() - 1, AnchorsText(json));
  if (!data.is_whole) cells.insert(cells.begin() + 1, ComponentText(scan));
  table->Row(cells, OpenDirections(json).empty() ? "" : "weak",
             ViewAttribute("scan", table->rows()));
}

}  // namespace

std::string OpenDirectionsHtml(const ReportData& data) {
  std::size_t count = 0;
  const std::string items = OpenItems(data, &count), motions = OpenMotions(*data.json);
  if (data.scans.empty()) return "";
  const std::string all = Grouped(static_cast<double>(count)) + " directions of single scans";
  // What many scans share stands once; the scans one by one can be unfolded.
  const std::string open = count == 0 && motions.empty()
                               ? "<p>None: the planes hold every scan in all six directions.</p>\n"
                               : motions + FoldedList(items, count, all, motions.empty() ? 12 : 0) +
                                     OdometryScales(*data.json);
  return Section("Directions that the planes leave open", open) +
         Section("Warnings", WarningsHtml(*data.json));
}

std::string ScansHtml(const ReportData& data) {
  const ScanTable all{HasFixed(data), OnlyDegenerate(*data.json)};
  std::vector<HtmlColumn> columns = {{"scan", "", false},
                                     {"points", ""},
                                     {"after filters", ""},
                                     {"planes", ""},
                                     {"position x, y, z", "m"},
                                     {"sigma", "mm"},
                                     {"sigma", "deg"},
                                     {"time", "s"},
                                     {WeakestHeading(data, all.has_fixed), "", false}};
  if (!data.maps.empty()) columns.insert(columns.end() - 1, {"in the map", "", false});
  if (!data.is_whole) columns.insert(columns.begin() + 1, {"component", ""});
  HtmlTable table(std::move(columns));
  for (const ReportScan& scan : data.scans) AddScan(data, scan, all, &table);
  if (table.rows() == 0) return "";
  return Section("Scans",
                 SigmaNote(data, all.has_fixed) +
                     table.Html("Table of all " + std::to_string(table.rows()) + " scans") +
                     WorldNote(data, all.has_fixed));
}

}  // namespace planegraph
