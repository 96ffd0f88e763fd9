#include <charconv>

#include "sweep/writers.h"

namespace planegraph {
namespace {

// The shortest text that reads back as the same number.
std::string ExactNumber(const std::optional<double>& value) {
  if (!value) return "";
  char buffer[64];
  return {buffer, std::to_chars(buffer, buffer + sizeof(buffer), *value).ptr};
}

// RFC 4180: quotes around what would otherwise be taken apart.
std::string Quoted(const std::string& text) {
  if (text.find_first_of(",\"\r\n") == std::string::npos) return text;
  std::string quoted = "\"";
  for (const char c : text) quoted += c == '"' ? std::string("\"\"") : std::string(1, c);
  return quoted + "\"";
}

std::string Line(const std::vector<std::string>& cells) {
  std::string line;
  for (std::size_t i = 0; i < cells.size(); ++i) line += (i > 0 ? "," : "") + Quoted(cells[i]);
  return line + "\n";
}

void AddInterval(const std::optional<Interval>& interval, std::vector<std::string>* cells) {
  cells->push_back(interval ? ExactNumber(interval->low) : "");
  cells->push_back(interval ? ExactNumber(interval->high) : "");
}

std::vector<std::string> Header(const Experiment& experiment) {
  std::vector<std::string> header{"data_set", "variant", "is_baseline", "runs", "succeeded"};
  for (const SweepMetric& metric : experiment.metrics) {
    const std::string change = metric.is_ratio ? "_ratio" : "_difference";
    for (const std::string& part :
         {std::string("_n"), std::string("_median"), std::string("_low"), std::string("_high"),
          std::string("_mean"), std::string("_min"), std::string("_max"), std::string("_pairs"),
          change, change + "_low", change + "_high", std::string("_p"), std::string("_p_holm")}) {
      header.push_back(metric.name + part);
    }
  }
  return header;
}

void AddCell(const SweepCell& cell, std::vector<std::string>* cells) {
  cells->push_back(std::to_string(cell.count));
  cells->push_back(ExactNumber(cell.median));
  AddInterval(cell.interval, cells);
  for (const auto& value : {cell.mean, cell.min, cell.max}) cells->push_back(ExactNumber(value));
  cells->push_back(std::to_string(cell.pairs));
  cells->push_back(ExactNumber(cell.change));
  AddInterval(cell.change_interval, cells);
  cells->push_back(ExactNumber(cell.p));
  cells->push_back(ExactNumber(cell.p_holm));
}

}  // namespace

std::string RunsCsv(const SweepContent& content) {
  std::vector<std::string> header{"data_set", "variant", "seed", "exit_code", "reason"};
  for (const SweepMetric& metric : content.experiment.metrics) header.push_back(metric.name);
  std::string text = Line(header);
  for (const SweepRun& run : content.runs) {
    std::vector<std::string> cells{content.experiment.data_sets[run.data_set].name,
                                   content.experiment.variants[run.variant].name,
                                   std::to_string(run.seed), std::to_string(run.exit_code),
                                   run.reason};
    for (const auto& value : run.values) cells.push_back(ExactNumber(value));
    text += Line(cells);
  }
  return text;
}

std::string TableCsv(const SweepContent& content) {
  std::string text = Line(Header(content.experiment));
  for (const SweepRow& row : content.rows) {
    std::vector<std::string> cells{row.data_set, row.variant, row.is_baseline ? "1" : "0",
                                   std::to_string(row.runs), std::to_string(row.succeeded)};
    for (const SweepCell& cell : row.cells) AddCell(cell, &cells);
    text += Line(cells);
  }
  return text;
}

}  // namespace planegraph
