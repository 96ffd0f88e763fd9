#include <algorithm>
#include <map>
#include <set>

#include "report/html.h"
#include "report/sections.h"

namespace planegraph {
namespace {

enum class Level { kGood, kFair, kBad };

struct Verdict {
  Level level = Level::kGood;
  std::string sentence;  ///< HTML
};

std::string Count(std::size_t n, const std::string& what) {
  return Grouped(static_cast<double>(n)) + " " + what + (n == 1 ? "" : "s");
}

std::size_t UsedRegistrations(const Json& json) {
  std::size_t used = 0;
  for (const Json& r : ListAt(json, {"registrations"})) {
    used += FlagAt(r, {"used"}).value_or(false) ? 1 : 0;
  }
  return used;
}

// Scans of each component, by the component's number.
std::map<int, std::size_t> ComponentSizes(const ReportData& data) {
  std::map<int, std::size_t> sizes;
  for (const ComponentScan& scan : ComponentScans(data)) ++sizes[scan.component];
  return sizes;
}

std::optional<std::size_t> ComponentCount(const ReportData& data) {
  const Json& components = Get(*data.json, {"components"});
  if (components.is_array()) return components.size();
  const auto count = NumberAt(*data.json, {"components"});
  if (count && *count >= 0 && *count < 1e9) return static_cast<std::size_t>(*count);
  return std::nullopt;
}

std::string SizesText(const ReportData& data) {
  std::string text;
  for (const auto& [component, size] : ComponentSizes(data)) {
    text += (text.empty() ? "" : ", ") + std::to_string(size);
  }
  return text.empty() ? "" : " (of " + text + " scans)";
}

// "; cart/010 | cart/013 to 015 stand apart", after what it is that they are not in.
std::string WhoStandsApart(const ReportData& data) {
  const std::string who = ApartText(ComponentScans(data));
  if (who.empty()) return "";
  return ": " + Escape(who) +
         (ApartPlacedByNothing(data) ? "; their place in plan and map means nothing" : "");
}

Verdict JoinedVerdict(const ReportData& data) {
  const std::size_t scans = data.scans.size();
  const std::size_t used = UsedRegistrations(*data.json);
  const auto components = ComponentCount(data);
  if (scans == 0) return {Level::kBad, "The report lists no scans"};
  if (!components) {
    return {Level::kFair, Count(scans, "scan") + "; in how many components is not said"};
  }
  if (*components <= 1) {
    return {Level::kGood,
            (scans == 1 ? "One scan in" : "All " + Count(scans, "scan") + " joined in") +
                " one component by " + Count(used, "registration")};
  }
  return {Level::kBad, "The " + Count(scans, "scan") + " do not form one component but " +
                           std::to_string(*components) + SizesText(data) + WhoStandsApart(data)};
}

// "4 of them are anchored to the drone map uav1, whose scale is 8.507 m per unit ± 0.20 %".
void AddMaps(const ReportData& data, Verdict* verdict) {
  for (const ReportMap& map : data.maps) {
    const std::string name = "the drone map " + TextOrDash(map.id);
    if (map.anchored == 0) {
      if (verdict->level == Level::kGood) verdict->level = Level::kFair;
      verdict->sentence += "; none is anchored to " + name;
      continue;
    }
    const auto scale = NumberAt(*map.json, {"world_from_map", "scale"});
    const auto sigma = NumberAt(*map.json, {"sigma_scale"});
    verdict->sentence += "; " + Grouped(static_cast<double>(map.anchored)) +
                         (map.anchored == 1 ? " is" : " are") + " anchored to " + name;
    if (!scale) continue;
    verdict->sentence += ", whose scale is " + Significant(*scale, 5) + "\u00a0m per unit";
    if (sigma) verdict->sentence += " ± " + Significant(100.0 * *sigma, 2) + "\u00a0%";
  }
}

std::string Listed(const std::set<std::string>& names) {
  std::string text;
  for (const std::string& name : names) text += (text.empty() ? "" : " and ") + Escape(name);
  return text;
}

// What GPS alone holds is no weakness: nothing else knows where in the world a site lies.
bool IsPlaceInWorld(const OpenDirection& open) {
  return open.held_by == "gps" && open.sigma && !open.is_rotation;
}

std::string PlaceInWorld(double sigma) {
  return "; where in the world they lie is known from GPS, to " + Significant(sigma, 2) + "\u00a0m";
}

void AddOpenDirections(const ReportData& data, Verdict* verdict) {
  std::size_t held = 0, free = 0;
  double by_gps = 0.0;
  std::set<std::string> holders;
  for (const ReportScan& scan : data.scans) {
    bool is_free = false;
    auto directions = OpenDirections(*scan.json);
    for (const OpenDirection& open : directions) {
      if (IsPlaceInWorld(open)) by_gps = std::max(by_gps, *open.sigma);
    }
    std::erase_if(directions, IsPlaceInWorld);
    for (const OpenDirection& open : directions) {
      is_free |= !open.sigma || open.held_by.empty();
      if (!open.held_by.empty()) holders.insert(open.held_by);
    }
    if (!directions.empty()) ++(is_free ? free : held);
  }
  if (by_gps > 0.0) verdict->sentence += PlaceInWorld(by_gps);
  if (held + free == 0) return;
  if (verdict->level == Level::kGood) verdict->level = Level::kFair;
  if (held > 0) {
    verdict->sentence += "; the planes leave a direction of " + Count(held, "scan") +
                         " open, held by " + Listed(holders);
  }
  if (free > 0) verdict->sentence += "; nothing holds a direction of " + Count(free, "scan");
}

Verdict Judge(const ReportData& data) {
  Verdict verdict = JoinedVerdict(data);
  AddMaps(data, &verdict);
  AddOpenDirections(data, &verdict);
  const bool solved = TextAt(*data.json, {"solve", "optimizer"}) != "none";  // there was a solve
  if (solved && !FlagAt(*data.json, {"solve", "converged"}).value_or(true)) {
    verdict.level = Level::kBad;
    verdict.sentence += "; the solve did not converge";
  }
  const std::string reason = TextAt(*data.json, {"reason"});
  if (!reason.empty()) verdict.sentence += "; " + Escape(reason);
  verdict.sentence += ".";
  return verdict;
}

std::string VerdictHtml(const Verdict& verdict) {
  static constexpr const char* kClasses[] = {"good", "fair", "bad"};
  static constexpr const char* kSigns[] = {"✓", "!", "✗"};
  const auto level = static_cast<std::size_t>(verdict.level);
  return std::string("<p class=\"verdict ") + kClasses[level] +
         "\"><span class=\"sign\" aria-hidden=\"true\">" + kSigns[level] + "</span><span>" +
         verdict.sentence + "</span></p>\n";
}

// ---- figures at a glance ----

std::string Figure(const std::string& value, const std::string& unit, const std::string& what) {
  return "<div><b>" + value + (unit.empty() ? "" : " <small>" + unit + "</small>") + "</b><span>" +
         what + "</span></div>\n";
}

std::string SumText(const ReportData& data, const char* key) {
  double sum = 0;
  bool any = false;
  for (const ReportScan& scan : data.scans) {
    const auto value = NumberAt(*scan.json, {key});
    sum += value.value_or(0.0);
    any = any || value;
  }
  return any ? Grouped(sum) : kDash;
}

std::string MapFigures(const ReportData& data) {
  double points = 0;
  for (const ReportMap& map : data.maps) points += NumberAt(*map.json, {"points"}).value_or(0.0);
  return points > 0 ? Figure(Grouped(points), "", "points of the drone") : "";
}

std::string AteFigures(const ReportData& data) {
  std::string html;
  const Json& evaluation = Get(*data.json, {"evaluation"});
  if (!evaluation.is_object()) return html;
  for (const auto& [robot, errors] : evaluation.items()) {
    const auto ate = NumberAt(errors, {"ate", "rmse"});
    if (ate) html += Figure(Fixed(*ate * 1000, 1), "mm", "ATE rmse of " + Escape(robot));
  }
  return html;
}

std::string FiguresHtml(const ReportData& data) {
  const Json& json = *data.json;
  const std::size_t tried = ListAt(json, {"registrations"}).size();
  std::string html = "<div class=\"figures\">\n";
  html += Figure(Grouped(static_cast<double>(data.scans.size())), "", "scans");
  html += Figure(SumText(data, "points"), "", "points of the scans");
  html += MapFigures(data);
  html += Figure(SumText(data, "planes"), "", "planes of the scans");
  html += Figure(Grouped(static_cast<double>(UsedRegistrations(json))) + " / " +
                     Grouped(static_cast<double>(tried)),
                 "", "registrations used / tried");
  html += AteFigures(data);
  html += Figure(FixedOrDash(NumberAt(json, {"seconds"}), 2), "s", "wall time");
  html += Figure(FixedOrDash(NumberAt(json, {"peak_memory_bytes"}), 0, 1e-6), "MB", "peak memory");
  return html + "</div>\n";
}

}  // namespace

std::string HeaderHtml(const ReportData& data) {
  const std::string name = TextAt(*data.json, {"name"});
  return "<header>\n<p class=\"brand\">Planegraph report</p>\n<h1>" +
         (name.empty() ? "Map" : Escape(name)) + "</h1>\n" + VerdictHtml(Judge(data)) +
         FiguresHtml(data) + "</header>\n";
}

}  // namespace planegraph
