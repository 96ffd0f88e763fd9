#include "sweep/writers.h"

#include <cmath>

#include "planegraph/base/atomic_file.h"
#include "planegraph/evaluation/median_interval.h"
#include "report/html.h"

namespace planegraph {
namespace {

std::string Number(const std::optional<double>& value) {
  if (!value) return "";
  const bool is_whole = *value == std::round(*value) && std::abs(*value) < 1e9;
  return is_whole ? Fixed(*value, 0) : Significant(*value, 4);
}

std::string Range(const std::optional<Interval>& interval) {
  return interval ? Number(interval->low) + ", " + Number(interval->high) : "";
}

std::string Probability(double p) { return p < 0.001 ? "<0.001" : Significant(p, 2); }

}  // namespace

CellText TextOf(const SweepContent& content, const SweepRow& row, std::size_t metric) {
  const SweepCell& cell = row.cells[metric];
  const bool is_ratio = content.experiment.metrics[metric].is_ratio;
  CellText text;
  if (is_ratio) {
    text.value = row.is_baseline && cell.count > 0 ? "1" : Number(cell.change);
    text.interval = Range(cell.change_interval);
    const std::string& unit = content.experiment.metrics[metric].unit;
    if (cell.median) text.absolute = Number(cell.median) + (unit.empty() ? "" : " " + unit);
  } else {
    text.value = Number(cell.median);
    text.interval = Range(cell.interval);
    if (cell.change) text.change = (*cell.change > 0.0 ? "+" : "") + Number(cell.change);
  }
  if (cell.p_holm) {
    text.p = Probability(*cell.p_holm);
    text.is_significant = *cell.p_holm <= 1.0 - content.experiment.level;
  }
  return text;
}

std::string UnitOf(const SweepMetric& metric) {
  if (!metric.is_ratio) return metric.unit;
  return "ratio";
}

std::string FlagText(const FlagValues& flags) {
  std::string text;
  for (const auto& [name, value] : flags) {
    text += (text.empty() ? "--" : " --") + name + "=" + value;
  }
  return text;
}

std::vector<std::string> NotesOf(const SweepContent& content) {
  const Experiment& experiment = content.experiment;
  const std::string percent = Number(100.0 * experiment.level) + " %";
  const std::string least = std::to_string(LeastForMedianInterval(experiment.level));
  return {
      "Medians over the runs that succeeded (exit code 0); how many of how many did is said. In "
      "brackets the " +
          percent + " interval of the median (bootstrap over all resamples).",
      "Below it the median difference to the baseline " +
          experiment.variants[experiment.baseline].name +
          " over equal data sets and seeds, and p of Wilcoxon's signed-rank test (exact up to 200 "
          "pairs), adjusted by Holm for all rows of the column, those over all data sets apart.",
      "Times and memory are ratios to the baseline's run on the same data set with the same seed, "
      "tested by their logarithms.",
      "With fewer than " + least +
          " values there is no interval and no test: none could hold at "
          "this level. Results of a site file that are equal for every seed count as one.",
      "Planegraph " + content.stamp.version + " (" + content.stamp.commit + "), " +
          (experiment.threads == 0 ? "all" : std::to_string(experiment.threads)) +
          (experiment.threads == 1 ? " thread" : " threads") + " in each run."};
}

void WriteSweepTables(const Experiment& experiment, const std::vector<SweepRun>& runs,
                      const std::vector<SweepRow>& rows, const SweepStamp& stamp,
                      const std::string& folder) {
  const SweepContent content{experiment, runs, rows, stamp};
  WriteTextFile(folder + "/sweep.csv", RunsCsv(content));
  WriteTextFile(folder + "/table.csv", TableCsv(content));
  WriteTextFile(folder + "/table.html", TableHtml(content));
  WriteTextFile(folder + "/table.tex", TableLatex(content));
  WriteTextFile(folder + "/table.md", TableMarkdown(content));
}

}  // namespace planegraph
