#pragma once

#include <optional>
#include <string>
#include <vector>

#include "planegraph/sweep/table.h"

namespace planegraph {

/// What the writers of the tables share.
struct SweepContent {
  const Experiment& experiment;
  const std::vector<SweepRun>& runs;
  const std::vector<SweepRow>& rows;
  const SweepStamp& stamp;
};

/// The parts of a cell as text, with ASCII minus signs; empty where there is nothing.
struct CellText {
  std::string value;     ///< median, or the ratio to the baseline of metrics that are ratios
  std::string interval;  ///< of it: "low, high"
  std::string absolute;  ///< of ratios: the median itself
  std::string change;    ///< median difference to the baseline, with its sign
  std::string p;         ///< adjusted
  bool is_significant = false;
};
CellText TextOf(const SweepContent& content, const SweepRow& row, std::size_t metric);

/// Head of a metric's column: its unit, or that ratios to the baseline are shown.
std::string UnitOf(const SweepMetric& metric);
/// Flags as a command line has them.
std::string FlagText(const FlagValues& flags);
/// Which versions made the table and what its figures are, in sentences.
std::vector<std::string> NotesOf(const SweepContent& content);

std::string RunsCsv(const SweepContent& content);
std::string TableCsv(const SweepContent& content);
std::string TableHtml(const SweepContent& content);
std::string TableLatex(const SweepContent& content);
std::string TableMarkdown(const SweepContent& content);

}  // namespace planegraph
