#include <algorithm>
#include <cmath>

#include "planegraph/base/angles.h"
#include "report/html.h"
#include "report/marks_svg.h"
#include "report/plot_svg.h"
#include "report/sections.h"

namespace planegraph {
namespace {

// A table of names and values; values are HTML.
class Facts {
 public:
  void Add(const std::string& name, const std::string& value) {
    if (value == kDash || value.empty()) return;
    rows_ += "<tr><th>" + Escape(name) + "</th><td>" + value + "</td></tr>\n";
  }
  std::string Html() const {
    if (rows_.empty()) return "";
    return "<div class=\"scroll\"><table class=\"facts\"><tbody>\n" + rows_ +
           "</tbody></table></div>\n";
  }

 private:
  std::string rows_;
};

// ---- evaluation ----

std::string AteConventions(const Json& ate) {
  const std::string alignment = TextAt(ate, {"alignment"});
  return "alignment " + TextOrDash(alignment) +
         (alignment == "first" ? " (the positions define no other)" : "");
}

std::string RpeConventions(const Json& rpe) {
  return "delta " + PlainOrDash(NumberAt(rpe, {"delta"})) + " " +
         Escape(TextAt(rpe, {"delta_unit"})) + ", pairs " + TextOrDash(TextAt(rpe, {"pairs"})) +
         " on the " + TextOrDash(TextAt(rpe, {"pairs_from"}));
}

void AddErrors(const std::string& robot, const char* what, const Json& errors,
               const std::string& conventions, HtmlTable* table) {
  if (!errors.is_object()) return;
  std::vector<std::string> cells = {Escape(robot), what,
                                    GroupedOrDash(NumberAt(errors, {"count"}))};
  for (const char* key : {"rmse", "mean", "median", "max"}) {
    cells.push_back(FixedOrDash(NumberAt(errors, {key}), 1, 1000.0));
  }
  for (const char* key : {"rmse", "max"}) {
    cells.push_back(FixedOrDash(NumberAt(errors, {"rotation", key}), 3, kDegreesPerRadian));
  }
  cells.push_back(conventions);
  table->Row(cells);
}

std::vector<double> FiniteNumbers(const Json& list, double factor) {
  std::vector<double> numbers;
  for (const Json& value : list) {
    if (value.is_number()) numbers.push_back(factor * value.get<double>());
  }
  return numbers;
}

std::string LineKey(const std::string& style, const std::string& text) {
  return LegendItem("<path class=\"way " + style + "\" d=\"M1 7H27\"/>", text);
}

// The errors of one robot, pose by pose and step by step.
std::string ErrorsPlot(const std::string& robot, const Json& errors) {
  const std::string plot =
      PlotHtml({{"r0", 0.0, FiniteNumbers(ListAt(errors, {"ate", "each"}), 1000.0)},
                {"r1", 0.0, FiniteNumbers(ListAt(errors, {"rpe", "each"}), 1000.0)}},
               {"Errors of " + robot + " along its way", "pose", "error of position [mm]"}, false);
  if (plot.empty()) return "";
  return plot + "<ul class=\"legend\">" + LineKey("r0", "ATE of " + Escape(robot)) +
         LineKey("r1", "RPE, from this pose to the next") + "</ul>\n";
}

// ---- solve ----

// Costs of different rounds are sums over different pairs of surfaces: each round is a line.
std::string CostPlot(const Json& solve) {
  std::vector<PlotLine> lines;
  double next = 0.0;
  for (const Json& round : ListAt(solve, {"costs"})) {
    if (!round.is_array()) continue;
    lines.push_back({RobotClass(lines.size() % 2), next, FiniteNumbers(round, 1.0)});
    next += static_cast<double>(lines.back().values.size());
  }
  const std::string plot = PlotHtml(lines, {"Cost of each iteration", "iteration", "cost"}, true);
  if (plot.empty()) return "";
  return plot +
         "<p class=\"note\">Cost of each iteration. A line is one solve; where surfaces were "
         "paired "
         "anew before it, its costs are another sum.</p>\n";
}

// ---- times ----

struct Stage {
  std::string name;
  double seconds = 0.0;
};

std::vector<Stage> Stages(const Json& json) {
  std::vector<Stage> stages;
  const Json& list = Get(json, {"stage_seconds"});
  if (!list.is_object()) return stages;
  // Known stages in the order in which they run, then any other.
  const std::vector<std::string> order = {"front_end", "maps",       "registration", "placing",
                                          "solve",     "covariance", "output"};
  for (const std::string& name : order) {
    const auto seconds = NumberAt(list, {name.c_str()});
    if (seconds) stages.push_back({name, std::max(0.0, *seconds)});
  }
  for (const auto& [name, seconds] : list.items()) {
    const bool known = std::find(order.begin(), order.end(), name) != order.end();
    if (known || !seconds.is_number()) continue;
    stages.push_back({name, std::max(0.0, seconds.get<double>())});
  }
  return stages;
}

std::string StageName(std::string name) {
  std::replace(name.begin(), name.end(), '_', ' ');
  return Escape(name);
}

std::string BarHtml(const std::vector<Stage>& stages, double total) {
  std::string svg =
      "<svg class=\"bar\" role=\"img\" aria-label=\"Share of each stage of the time\" "
      "viewBox=\"0 0 1000 28\" preserveAspectRatio=\"none\">\n";
  double at = 0.0;
  for (std::size_t i = 0; i < stages.size(); ++i) {
    const double width = 1000.0 * stages[i].seconds / total;
    svg += "<rect class=\"s" + std::to_string(i % 7) + "\" x=\"" + Fixed(at, 1) +
           "\" y=\"0\" width=\"" + Fixed(width, 1) + "\" height=\"28\"><title>" +
           StageName(stages[i].name) + "</title></rect>\n";
    at += width;
  }
  return svg + "</svg>\n";
}

std::string BarLegend(const std::vector<Stage>& stages, double total) {
  std::string items;
  for (std::size_t i = 0; i < stages.size(); ++i) {
    items += "<li><svg class=\"key\" viewBox=\"0 0 28 14\"><rect class=\"s" +
             std::to_string(i % 7) + "\" x=\"4\" y=\"1\" width=\"20\" height=\"12\"/></svg>" +
             StageName(stages[i].name) + " " + Fixed(stages[i].seconds, 3) + " s (" +
             Fixed(100.0 * stages[i].seconds / total, 0) + " %)</li>";
  }
  return "<ul class=\"legend\">" + items + "</ul>\n";
}

// ---- configuration ----

std::string ValueText(const Json& value) {
  if (value.is_string()) return "<code>" + TextOrDash(value.get<std::string>()) + "</code>";
  return value.is_null()
             ? kDash
             : "<code>" + Escape(value.dump(-1, ' ', false, Json::error_handler_t::replace)) +
                   "</code>";
}

// Objects become one row for each leaf, named by its way.
void AddLeaves(const std::string& name, const Json& value, Facts* facts) {
  if (!value.is_object()) return facts->Add(name, ValueText(value));
  for (const auto& [key, inner] : value.items()) {
    AddLeaves(name.empty() ? key : name + "." + key, inner, facts);
  }
}

std::string CommandText(const Json& stamp) {
  const Json& command = Get(stamp, {"command"});
  if (!command.is_array()) return ValueText(command);
  std::string text;
  for (const Json& word : command) {
    if (word.is_string()) text += (text.empty() ? "" : " ") + word.get<std::string>();
  }
  return "<code>" + Escape(text) + "</code>";
}

}  // namespace

std::string EvaluationHtml(const ReportData& data) {
  HtmlTable table({{"robot", "", false},
                   {"error", "", false},
                   {"count", ""},
                   {"rmse", "mm"},
                   {"mean", "mm"},
                   {"median", "mm"},
                   {"max", "mm"},
                   {"rotation rmse", "deg"},
                   {"rotation max", "deg"},
                   {"conventions", "", false}});
  std::string plots;
  const Json& evaluation = Get(*data.json, {"evaluation"});
  if (evaluation.is_object()) {
    for (const auto& [robot, errors] : evaluation.items()) {
      plots += ErrorsPlot(robot, errors);
      const Json &ate = Get(errors, {"ate"}), &rpe = Get(errors, {"rpe"});
      AddErrors(robot, "ATE", ate, AteConventions(ate), &table);
      AddErrors(robot, "RPE", rpe, RpeConventions(rpe), &table);
    }
  }
  return Section("Errors against the reference", table.Html("Table of the errors") + plots);
}

std::string SolveHtml(const ReportData& data) {
  const Json& solve = Get(*data.json, {"solve"});
  const auto converged = FlagAt(solve, {"converged"});
  Facts facts;
  facts.Add("optimizer", TextOrDash(TextAt(solve, {"optimizer"})));
  facts.Add("plane factor", TextOrDash(TextAt(solve, {"plane_factor"})));
  facts.Add("robust loss", TextOrDash(TextAt(solve, {"loss"})));
  facts.Add("size of the noise by",
            TextOrDash(TextAt(*data.json, {"configuration", "covariance"})));
  facts.Add("cost before the last round", SignificantOrDash(NumberAt(solve, {"initial_cost"}), 6));
  facts.Add("cost at the end", SignificantOrDash(NumberAt(solve, {"final_cost"}), 6));
  facts.Add("iterations of the last solve", GroupedOrDash(NumberAt(solve, {"iterations"})));
  facts.Add("rounds of association", GroupedOrDash(NumberAt(solve, {"rounds"})));
  facts.Add("converged", !converged ? kDash : *converged ? "yes" : "no");
  facts.Add("plane landmarks", GroupedOrDash(NumberAt(solve, {"landmarks"})));
  facts.Add("redundancy", GroupedOrDash(NumberAt(solve, {"redundancy"})));
  facts.Add("observations of landmarks", GroupedOrDash(NumberAt(solve, {"observations"})));
  const auto offset = NumberAt(solve, {"floor_offset"}), tilt = NumberAt(solve, {"floor_tilt"});
  if (offset) facts.Add("noise floor, offset", Fixed(*offset * 1000.0, 2) + " mm");
  if (tilt) facts.Add("noise floor, tilt", Fixed(*tilt * kDegreesPerRadian, 4) + "°");
  const auto seconds = NumberAt(solve, {"seconds"});
  if (seconds) facts.Add("time", Fixed(*seconds, 3) + " s");
  return Section("Solve", CostPlot(solve) + facts.Html());
}

std::string TimesHtml(const ReportData& data) {
  const std::vector<Stage> stages = Stages(*data.json);
  double total = 0.0;
  for (const Stage& stage : stages) total += stage.seconds;
  if (total <= 0.0) return "";
  return Section("Wall time of the stages", BarHtml(stages, total) + BarLegend(stages, total));
}

std::string ConfigurationHtml(const ReportData& data) {
  const Json& stamp = Get(*data.json, {"planegraph"});
  Facts facts;
  facts.Add("version", TextOrDash(TextAt(stamp, {"version"})));
  facts.Add("commit", TextOrDash(TextAt(stamp, {"commit"})));
  facts.Add("command", CommandText(stamp));
  facts.Add("seed", GroupedOrDash(NumberAt(stamp, {"seed"})));
  AddLeaves("flag", Get(stamp, {"flags"}), &facts);
  AddLeaves("", Get(*data.json, {"configuration"}), &facts);
  AddLeaves("origin", Get(*data.json, {"origin"}), &facts);
  return Section("Configuration", facts.Html());
}

}  // namespace planegraph
