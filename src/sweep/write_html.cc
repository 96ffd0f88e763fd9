#include <algorithm>

#include "report/html.h"
#include "report/style.h"
#include "sweep/writers.h"

namespace planegraph {
namespace {

std::string WithMinus(const std::string& text) {
  std::string result;
  for (std::size_t i = 0; i < text.size(); ++i) {
    const bool exponent = i > 0 && text[i - 1] == 'e';
    result += text[i] == '-' && !exponent ? std::string("−") : Escape(text.substr(i, 1));
  }
  return result;
}

std::string Small(const std::string& html) { return "<br><small>" + html + "</small>"; }

std::string CellHtml(const CellText& text) {
  if (text.value.empty()) return text.absolute.empty() ? "" : Small(WithMinus(text.absolute));
  const std::string value = WithMinus(text.value);
  std::string html = text.is_significant ? "<b>" + value + "</b>" : value;
  if (!text.interval.empty()) html += Small("[" + WithMinus(text.interval) + "]");
  std::string compared = WithMinus(text.change);
  if (!text.absolute.empty()) compared = WithMinus(text.absolute);
  if (!text.p.empty()) compared += (compared.empty() ? "p " : ", p ") + WithMinus(text.p);
  return compared.empty() ? html : html + Small(compared);
}

std::string SuccessHtml(const SweepRow& row) {
  const std::string text = std::to_string(row.succeeded) + " of " + std::to_string(row.runs);
  if (row.succeeded == row.runs) return text;
  return "<span class=\"" + std::string(row.succeeded == 0 ? "bad" : "fair") + "\">" + text +
         "</span>";
}

std::string MedianTable(const SweepContent& content) {
  std::vector<HtmlColumn> columns{
      {"Data set", "", false}, {"Variant", "", false}, {"Succeeded", "runs"}};
  for (const SweepMetric& metric : content.experiment.metrics) {
    columns.push_back({metric.name, UnitOf(metric)});
  }
  HtmlTable table(columns);
  for (const SweepRow& row : content.rows) {
    std::vector<std::string> cells{Escape(row.data_set),
                                   Escape(row.variant) + (row.is_baseline ? " (baseline)" : ""),
                                   SuccessHtml(row)};
    for (std::size_t m = 0; m < row.cells.size(); ++m) {
      cells.push_back(CellHtml(TextOf(content, row, m)));
    }
    table.Row(cells);
  }
  return table.Html("Table", content.rows.size());
}

std::string FailureTable(const SweepContent& content) {
  HtmlTable table({{"Data set", "", false},
                   {"Variant", "", false},
                   {"Seed", ""},
                   {"Exit code", ""},
                   {"Reason", "", false}});
  for (const SweepRun& run : content.runs) {
    if (run.succeeded()) continue;
    table.Row({Escape(content.experiment.data_sets[run.data_set].name),
               Escape(content.experiment.variants[run.variant].name), std::to_string(run.seed),
               std::to_string(run.exit_code), Escape(run.reason)});
  }
  return table.Html(std::to_string(table.rows()) + " runs failed");
}

std::string RunTable(const SweepContent& content) {
  std::vector<HtmlColumn> columns{
      {"Data set", "", false}, {"Variant", "", false}, {"Seed", ""}, {"Exit code", ""}};
  for (const SweepMetric& metric : content.experiment.metrics) {
    columns.push_back({metric.name, metric.unit});
  }
  HtmlTable table(columns);
  for (const SweepRun& run : content.runs) {
    std::vector<std::string> cells{Escape(content.experiment.data_sets[run.data_set].name),
                                   Escape(content.experiment.variants[run.variant].name),
                                   std::to_string(run.seed), std::to_string(run.exit_code)};
    for (const auto& value : run.values) {
      cells.push_back(value ? WithMinus(Significant(*value, 4)) : "");
    }
    table.Row(cells);
  }
  return table.Html("All " + std::to_string(content.runs.size()) + " runs", 0);
}

std::string VariantTable(const Experiment& experiment) {
  HtmlTable table({{"Variant", "", false}, {"Flags of map", "", false}});
  for (const SweepVariant& variant : experiment.variants) {
    const std::string flags = FlagText(variant.flags);
    table.Row(
        {Escape(variant.name), flags.empty() ? "none" : "<code>" + Escape(flags) + "</code>"});
  }
  return table.Html("Variants");
}

std::string DataSetTable(const Experiment& experiment) {
  HtmlTable table({{"Data set", "", false}, {"Seeds", ""}, {"From", "", false}});
  for (const SweepDataSet& set : experiment.data_sets) {
    const std::string from = set.is_simulated()
                                 ? "<code>" + Escape("simulate " + FlagText(set.simulate)) +
                                       "</code>, " + Escape(set.map_file)
                                 : Escape(set.site);
    table.Row({Escape(set.name), std::to_string(set.seeds.size()), from});
  }
  return table.Html("Data sets");
}

std::string Figure(std::size_t count, const std::string& what) {
  return "<div><b>" + std::to_string(count) + "</b><span>" + what + "</span></div>\n";
}

std::string Head(const SweepContent& content) {
  const std::string name = Escape(content.experiment.name);
  const auto failed =
      static_cast<std::size_t>(std::count_if(content.runs.begin(), content.runs.end(),
                                             [](const SweepRun& run) { return !run.succeeded(); }));
  return "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n"
         "<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n<title>" +
         name + " – Planegraph sweep</title>\n<style>" + kReportStyle +
         "</style>\n</head>\n<body>\n<header>\n<p class=\"brand\">Planegraph sweep</p>\n<h1>" +
         name + "</h1>\n<div class=\"figures\">\n" +
         Figure(content.experiment.variants.size(), "variants") +
         Figure(content.experiment.data_sets.size(), "data sets") +
         Figure(content.runs.size(), "runs") + Figure(failed, "of them failed") +
         "</div>\n</header>\n";
}

std::string NotesHtml(const SweepContent& content) {
  std::string html = "<ul class=\"words\">\n";
  for (const std::string& note : NotesOf(content)) html += "<li>" + Escape(note) + "</li>\n";
  return html + "<li>Bold: p at or below " + Significant(1.0 - content.experiment.level, 2) +
         ".</li>\n</ul>\n";
}

}  // namespace

std::string TableHtml(const SweepContent& content) {
  return Head(content) + "<main>\n" + Section("Medians", MedianTable(content)) +
         Section("How to read it", NotesHtml(content)) +
         Section("Failed runs", FailureTable(content)) +
         Section("Variants", VariantTable(content.experiment)) +
         Section("Data sets", DataSetTable(content.experiment)) +
         Section("Runs", RunTable(content)) +
         "</main>\n<footer><p>The same figures are in table.csv and sweep.csv.</p></footer>\n"
         "</body>\n</html>\n";
}

}  // namespace planegraph
