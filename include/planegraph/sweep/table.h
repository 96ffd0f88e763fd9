#pragma once

#include <optional>
#include <string>
#include <vector>

#include "planegraph/evaluation/interval.h"
#include "planegraph/sweep/experiment.h"
#include "planegraph/sweep/sweep.h"

namespace planegraph {

/// One metric of one variant on one data set, over its successful runs.
struct SweepCell {
  std::size_t count = 0;  ///< values; equal results of the same files count once
  std::optional<double> median, mean, min, max;
  std::optional<Interval> interval;  ///< of the median (bootstrap)

  /// Against the baseline, over data sets and seeds in which both succeeded: the median of the
  /// differences (variant less baseline) or, of metrics that are ratios, of the quotients.
  std::size_t pairs = 0;
  std::optional<double> change;
  std::optional<Interval> change_interval;
  /// Of Wilcoxon's signed-rank test (of the logarithms of quotients), and adjusted by Holm for all
  /// rows of the metric. Nothing for the baseline and with so few pairs that nothing could show.
  std::optional<double> p, p_holm;
};

/// The metrics that no run has a value of: names that were mistyped, or what the data do not show.
std::vector<std::string> EmptyMetrics(const Experiment& experiment,
                                      const std::vector<SweepRun>& runs);
/// Takes a metric out of the experiment and the runs' values.
void LeaveOut(const std::string& metric, Experiment* experiment, std::vector<SweepRun>* runs);

struct SweepRow {
  std::string data_set;  ///< `all`: all of them together
  std::string variant;
  bool is_baseline = false;
  std::size_t runs = 0, succeeded = 0;
  std::vector<SweepCell> cells;  ///< of the experiment's metrics
};

/// The table: a row for every data set and variant, and for every variant over all data sets where
/// there are several. Rows do not depend on the order of the variants. Values of a site file (not
/// simulated) that are equal for all seeds, so that the seed says nothing, count as one.
std::vector<SweepRow> MakeSweepTable(const Experiment& experiment,
                                     const std::vector<SweepRun>& runs);

/// What stands beside the table.
struct SweepStamp {
  std::string version, commit;
};

/// Writes into the folder: sweep.csv (a line for each run), table.csv, table.html, table.tex (a
/// tabular) and table.md (a row for each data set and variant). Each appears whole or not at all.
void WriteSweepTables(const Experiment& experiment, const std::vector<SweepRun>& runs,
                      const std::vector<SweepRow>& rows, const SweepStamp& stamp,
                      const std::string& folder);

}  // namespace planegraph
