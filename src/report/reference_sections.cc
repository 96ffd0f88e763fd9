#include "report/html.h"
#include "report/sections.h"

namespace planegraph {
namespace {

std::string Share(const Json& coverage, const char* level) {
  return FixedOrDash(NumberAt(coverage, {level}), 2);
}

std::string BandText(const Json& part) {
  const auto band = NumbersAt(part, {"band"}, 2);
  return band ? Fixed((*band)[0], 2) + " to " + Fixed((*band)[1], 2) : kDash;
}

std::string MannerOf(const Json& part) {
  const std::string from = TextAt(part, {"relative_to"});
  const std::string jointly =
      FlagAt(part, {"joint"}).value_or(false) ? "all poses jointly" : "each pose by itself";
  return jointly + (from.empty() ? "" : ", relative to " + Escape(from));
}

void AddPoses(const Json& robots, HtmlTable* table) {
  if (!robots.is_object()) return;
  for (const auto& [robot, part] : robots.items()) {
    const Json& coverage = Get(part, {"coverage"});
    table->Row({Escape(robot), GroupedOrDash(NumberAt(part, {"count"})),
                GroupedOrDash(NumberAt(part, {"degrees_of_freedom"})),
                FixedOrDash(NumberAt(part, {"nees"}), 2), BandText(part), Share(coverage, "50"),
                Share(coverage, "90"), Share(coverage, "95"), MannerOf(part)});
  }
}

void AddMaps(const Json& maps, HtmlTable* table) {
  if (!maps.is_object()) return;
  for (const auto& [map, part] : maps.items()) {
    table->Row({"scale of " + Escape(map), "1", "1", FixedOrDash(NumberAt(part, {"nees"}), 2),
                kDash, kDash, kDash, kDash, "logarithm of the scale"});
  }
}

}  // namespace

std::string ConsistencyHtml(const ReportData& data) {
  const Json& consistency = Get(*data.json, {"reference", "consistency"});
  HtmlTable table({{"robot", "", false},
                   {"errors", ""},
                   {"degrees of freedom", ""},
                   {"NEES / degrees of freedom", ""},
                   {"95 % of honest ones", ""},
                   {"within 50\u00a0%", "share"},
                   {"within 90\u00a0%", "share"},
                   {"within 95\u00a0%", "share"},
                   {"what", "", false}});
  AddPoses(Get(consistency, {"robots"}), &table);
  AddMaps(Get(consistency, {"maps"}), &table);
  if (table.rows() == 0) return "";
  return Section("Are the uncertainties honest?",
                 "<p class=\"note\">NEES: the squared errors in units of their covariances. Above "
                 "the band the covariances are too small, below it too large.</p>\n" +
                     table.Html("Table of the normalized errors"));
}

}  // namespace planegraph
