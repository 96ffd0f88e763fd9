#include <cmath>

#include "planegraph/base/counted.h"
#include "report/html.h"
#include "report/sections.h"

namespace planegraph {
namespace {

std::string ScaleText(const Json& map) {
  const auto scale = NumberAt(map, {"world_from_map", "scale"});
  const auto sigma = NumberAt(map, {"sigma_scale"});
  if (!scale) return kDash;
  return Significant(*scale, 6) + (sigma ? " ± " + Significant(100.0 * *sigma, 2) + "\u00a0%" : "");
}

std::string GpsScaleText(const Json& map) {
  const Json& gps = Get(map, {"georeference"});
  const auto scale = NumberAt(gps, {"scale"}), sigma = NumberAt(gps, {"sigma_scale"});
  if (!scale || TextAt(gps, {"status"}) != "ok") return kDash;
  return Significant(*scale, 6) + (sigma ? " ± " + Significant(100.0 * *sigma, 2) + "\u00a0%" : "");
}

// How far the scans moved the scale that GPS gave.
std::string ScaleChangeText(const Json& map) {
  const auto scale = NumberAt(map, {"world_from_map", "scale"});
  const auto before = NumberAt(map, {"georeference", "scale"});
  if (!scale || !before || *before <= 0.0 || TextAt(map, {"georeference", "status"}) != "ok") {
    return kDash;
  }
  const double percent = 100.0 * (*scale / *before - 1.0);
  return (percent > 0 ? "+" : "") + Fixed(percent, 2);
}

std::string FixesText(const Json& map) {
  const auto inliers = NumberAt(map, {"georeference", "inliers"});
  const auto fixes = NumberAt(map, {"georeference", "fixes"});
  if (!inliers || !fixes) return kDash;
  return Grouped(*inliers) + " / " + Grouped(*fixes);
}

std::string NoteText(const ReportMap& map) {
  const Json& gps = Get(*map.json, {"georeference"});
  std::string note;
  if (!gps.is_object()) note = "no positions of its cameras";
  if (gps.is_object() && TextAt(gps, {"status"}) != "ok") {
    note = "no place by GPS: " + Escape(TextAt(gps, {"reason"}));
  }
  const Json& tiles = Get(*map.json, {"tiles"});
  if (tiles.is_object()) {
    note += (note.empty() ? "" : "; ") + Counted(Get(tiles, {"nodes"}).size(), "tile") +
            ", bent by " + FixedOrDash(NumberAt(tiles, {"rms"}), 0, 1000.0) + "\u00a0mm rms, " +
            FixedOrDash(NumberAt(tiles, {"largest"}), 0, 1000.0) + "\u00a0mm at most";
  }
  if (map.anchored == 0) note += (note.empty() ? "" : "; ") + std::string("not in map.ply");
  return note;
}

void AddMap(const ReportMap& map, std::size_t scans, HtmlTable* table) {
  const Json& json = *map.json;
  table->Row(
      {TextOrDash(map.id), GroupedOrDash(NumberAt(json, {"points"})),
       GroupedOrDash(NumberAt(json, {"planes"})),
       FixedOrDash(NumberAt(json, {"noise", "constant"}), 1, 1000.0),
       Grouped(static_cast<double>(map.anchored)) + " / " + Grouped(static_cast<double>(scans)),
       ScaleText(json), GpsScaleText(json), ScaleChangeText(json), FixesText(json),
       FixedOrDash(NumberAt(json, {"georeference", "rms"}), 2), NoteText(map)},
      map.anchored == 0 ? "weak" : "");
}

std::string WorldText(const Json& json) {
  const auto lat = NumberAt(json, {"origin", "lat"}), lon = NumberAt(json, {"origin", "lon"});
  const auto alt = NumberAt(json, {"origin", "alt"});
  if (!lat || !lon) return "";
  return " The world is east-north-up, its origin at latitude " + Fixed(*lat, 7) + "°, longitude " +
         Fixed(*lon, 7) + "°" + (alt ? ", altitude " + Fixed(*alt, 2) + "\u00a0m" : "") + ".";
}

}  // namespace

std::string MapsHtml(const ReportData& data) {
  if (data.maps.empty()) return "";
  HtmlTable table({{"map", "", false},
                   {"points", ""},
                   {"planes", ""},
                   {"noise", "mm"},
                   {"scans anchored", ""},
                   {"scale", "m per unit"},
                   {"scale by GPS alone", "m per unit"},
                   {"change", "%"},
                   {"GPS fixes used", ""},
                   {"their rms", "m"},
                   {"note", "", false}});
  for (const ReportMap& map : data.maps) AddMap(map, data.scans.size(), &table);
  return Section("Drone maps",
                 "<p class=\"note\">Scale: of the joint solution, with its standard deviation." +
                     WorldText(*data.json) + "</p>\n" + table.Html("Table of the maps"));
}

}  // namespace planegraph
