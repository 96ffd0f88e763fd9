#include <algorithm>
#include <cmath>

#include "report/html.h"
#include "report/sections.h"

namespace planegraph {
namespace {

constexpr double kDegrees = 180.0 / M_PI;

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
  const std::string list = "<ul class=\"words\">\n" + items + "</ul>\n";
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

std::string SigmaText(const ReportScan& scan, int first, double factor, int decimals) {
  if (!scan.covariance) return kDash;
  return Fixed(WeakestAxis(*scan.covariance, first).sigma * factor, decimals);
}

bool IsFixed(const ReportScan& scan) { return scan.covariance && scan.covariance->isZero(0.0); }

// Covariances are relative to a fixed scan; where GPS holds all scans, there is none.
bool HasFixed(const ReportData& data) {
  return std::any_of(data.scans.begin(), data.scans.end(), IsFixed);
}

std::string WeakestText(const ReportScan& scan, bool has_fixed) {
  const auto open = OpenDirections(*scan.json);
  if (!open.empty()) return InWords(open.front()) + ", " + HoldInWords(open.front());
  if (IsFixed(scan)) return "fixed: the world's frame";
  if (!scan.covariance) return kDash;
  const Weakest weakest = WeakestAxis(*scan.covariance, 0);
  OpenDirection words;
  words.axis = weakest.axis;
  // In the world's frame GPS has its share in every direction.
  return InWords(words) + (has_fixed ? ", held by planes" : "");
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

// What the 3-D view is asked for by this row.
std::string ViewAttribute(const char* kind, std::size_t index) {
  return std::string(" data-") + kind + "=\"" + std::to_string(index) + "\"";
}

void AddScan(const ReportScan& scan, bool has_maps, bool has_fixed, HtmlTable* table) {
  const Json& json = *scan.json;
  std::vector<std::string> cells = {TextOrDash(scan.id),
                                    GroupedOrDash(NumberAt(json, {"points"})),
                                    GroupedOrDash(NumberAt(json, {"points_filtered"})),
                                    GroupedOrDash(NumberAt(json, {"planes"})),
                                    PositionText(scan),
                                    SigmaText(scan, 0, 1000.0, 1),
                                    SigmaText(scan, 3, kDegrees, 3),
                                    SecondsText(json),
                                    WeakestText(scan, has_fixed)};
  if (has_maps) cells.insert(cells.end() - 1, AnchorsText(json));
  table->Row(cells, OpenDirections(json).empty() ? "" : "weak",
             ViewAttribute("scan", table->rows()));
}

// ---- registrations ----

std::string CorrespondencesText(const Json& r) {
  const Json& value = Get(r, {"correspondences"});
  if (value.is_array()) return Grouped(static_cast<double>(value.size()));
  return GroupedOrDash(NumberAt(r, {"correspondences"}));
}

// The direction that a registration knows least of, with its standard deviation.
std::string WeakestOf(const Json& r) {
  constexpr double kUnknown = 100.0;  // metres: beyond, nothing but the solver's damping holds it
  const auto covariance = CovarianceOf(r);
  if (!covariance) return kDash;
  const Weakest weakest = WeakestAxis(*covariance, 0);
  std::string axis;  // in one piece, wherever the line breaks
  for (int k = 0; k < 3; ++k) axis += (k > 0 ? ",\u00a0" : "") + Fixed(weakest.axis[k], 1);
  return (weakest.sigma < kUnknown ? Fixed(1000.0 * weakest.sigma, 1) + "\u00a0mm" : "open") +
         " along (" + axis + ")";
}

std::string NoteText(const Json& r) {
  std::string note = Escape(TextAt(r, {"reason"}));
  for (const OpenDirection& open : OpenDirections(r)) {
    note += (note.empty() ? "" : "; ") + InWords(open) + " not observed";
  }
  return note;
}

std::string StatusText(const std::string& status) {
  if (status.empty()) return kDash;
  return "<span class=\"status " + std::string(status == "ok" ? "good" : "fair") + "\">" +
         Escape(status) + "</span>";
}

std::string UsedText(const std::optional<bool>& used) {
  if (!used) return kDash;
  return *used ? "yes" : "no";
}

void AddRegistration(const Json& r, HtmlTable* table) {
  table->Row({TextOrDash(TextAt(r, {"target"})), TextOrDash(TextAt(r, {"source"})),
              TextOrDash(TextAt(r, {"kind"})), StatusText(TextAt(r, {"status"})),
              UsedText(FlagAt(r, {"used"})), CorrespondencesText(r),
              GroupedOrDash(NumberAt(r, {"surfels"})), FixedOrDash(NumberAt(r, {"rms"}), 1, 1000.0),
              FixedOrDash(NumberAt(r, {"tilt_rms"}), 2, 1000.0),
              GroupedOrDash(NumberAt(r, {"redundancy"})), FixedOrDash(NumberAt(r, {"quality"}), 2),
              FixedOrDash(NumberAt(r, {"seconds"}), 3), WeakestOf(r), NoteText(r)},
             FlagAt(r, {"used"}).value_or(true) ? "" : "unused",
             ViewAttribute("registration", table->rows()));
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
  const bool has_maps = !data.maps.empty(), has_fixed = HasFixed(data);
  std::vector<HtmlColumn> columns = {{"scan", "", false},
                                     {"points", ""},
                                     {"after filters", ""},
                                     {"planes", ""},
                                     {"position x, y, z", "m"},
                                     {"sigma", "mm"},
                                     {"sigma", "deg"},
                                     {"time", "s"},
                                     {WeakestHeading(data, has_fixed), "", false}};
  if (has_maps) columns.insert(columns.end() - 1, {"in the map", "", false});
  HtmlTable table(std::move(columns));
  for (const ReportScan& scan : data.scans) AddScan(scan, has_maps, has_fixed, &table);
  if (table.rows() == 0) return "";
  return Section("Scans",
                 "<p class=\"note\">Sigma: of the position along its weakest direction, and of the "
                 "rotation about its weakest axis, " +
                     std::string(has_fixed ? "relative to the fixed scan" : "in the world frame") +
                     ".</p>\n" +
                     table.Html("Table of all " + std::to_string(table.rows()) + " scans"));
}

std::string RegistrationsHtml(const ReportData& data) {
  HtmlTable table({{"target", "", false},
                   {"source", "", false},
                   {"kind", "", false},
                   {"status", "", false},
                   {"used", "", false},
                   {"pairs of planes", ""},
                   {"of patches", ""},
                   {"residual", "mm"},
                   {"tilt", "mrad"},
                   {"redundancy", ""},
                   {"quality", ""},
                   {"time", "s"},
                   {"weakest direction", "", false},
                   {"why not used, and what is open", "", false}});
  for (const Json& r : ListAt(*data.json, {"registrations"})) AddRegistration(r, &table);
  return table.Html("Table of all " + std::to_string(table.rows()) + " registrations");
}

}  // namespace planegraph
