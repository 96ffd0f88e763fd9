// planegraph sweep: variants x data sets x seeds to one table.
#include <gflags/gflags.h>

#include <algorithm>
#include <filesystem>
#include <iostream>

#include "planegraph/base/atomic_file.h"
#include "planegraph/sweep/table.h"
#include "planegraph_version.h"
#include "tools/command.h"
#include "tools/commands.h"
#include "tools/common_flags.h"
#include "tools/progress.h"

DEFINE_string(data_dir, "",
              "folder that the experiment's site files are relative to (default: its own)");

namespace planegraph::tools {
namespace {

std::vector<std::string> FlagsOf(const std::string& command) {
  for (const Command& known : AllCommands()) {
    if (known.name == command) return known.flags;
  }
  return {};
}

// The sweep itself says where results go, and names seed and threads.
std::string CheckFlag(const std::string& command, const std::string& flag,
                      const std::string& value) {
  const std::vector<std::string> flags = FlagsOf(command);
  const bool known = std::find(flags.begin(), flags.end(), flag) != flags.end();
  if (!known || flag == "output_dir") {
    std::string names;
    for (const auto& name : flags) {
      if (name != "output_dir") names += (names.empty() ? "" : ", ") + name;
    }
    return "planegraph " + command + " has no flag " + flag + " here (" + names + ")";
  }
  const gflags::FlagSaver saver;
  const bool fits = !gflags::SetCommandLineOption(flag.c_str(), value.c_str()).empty();
  return fits ? "" : "the flag " + flag + " cannot be '" + value + "'";
}

void DrawSweepProgress(const std::string& run, double done) {
  std::fprintf(stderr, "\r%5.1f %%  %-60.60s%s", 100.0 * done, run.c_str(),
               done >= 1.0 ? "\n" : "");
}

nlohmann::json Number(const std::optional<double>& value) {
  return value ? nlohmann::json(*value) : nlohmann::json(nullptr);
}

nlohmann::json RangeJson(const std::optional<Interval>& interval) {
  return interval ? nlohmann::json{interval->low, interval->high} : nlohmann::json(nullptr);
}

nlohmann::json CellJson(const SweepCell& cell, bool is_ratio) {
  const std::string change = is_ratio ? "ratio" : "difference";
  return {{"n", cell.count},
          {"median", Number(cell.median)},
          {"interval", RangeJson(cell.interval)},
          {"mean", Number(cell.mean)},
          {"min", Number(cell.min)},
          {"max", Number(cell.max)},
          {"pairs", cell.pairs},
          {change, Number(cell.change)},
          {change + "_interval", RangeJson(cell.change_interval)},
          {"p", Number(cell.p)},
          {"p_holm", Number(cell.p_holm)}};
}

nlohmann::json TableJson(const Experiment& experiment, const std::vector<SweepRow>& rows) {
  nlohmann::json table = nlohmann::json::array();
  for (const SweepRow& row : rows) {
    nlohmann::json json = {{"data_set", row.data_set},       {"variant", row.variant},
                           {"is_baseline", row.is_baseline}, {"runs", row.runs},
                           {"succeeded", row.succeeded},     {"metrics", nlohmann::json::object()}};
    for (std::size_t m = 0; m < row.cells.size(); ++m) {
      const SweepMetric& metric = experiment.metrics[m];
      json["metrics"][metric.name] = CellJson(row.cells[m], metric.is_ratio);
    }
    table.push_back(json);
  }
  return table;
}

nlohmann::json FailuresJson(const Experiment& experiment, const std::vector<SweepRun>& runs) {
  nlohmann::json list = nlohmann::json::array();
  for (const SweepRun& run : runs) {
    if (run.succeeded()) continue;
    list.push_back({{"data_set", experiment.data_sets[run.data_set].name},
                    {"variant", experiment.variants[run.variant].name},
                    {"seed", run.seed},
                    {"exit_code", run.exit_code},
                    {"reason", run.reason}});
  }
  return list;
}

std::size_t Reused(const std::vector<SweepRun>& runs) {
  return static_cast<std::size_t>(
      std::count_if(runs.begin(), runs.end(), [](const SweepRun& run) { return run.reused; }));
}

// Whether every row has a run to tell of; says which have none.
bool Complete(const std::vector<SweepRow>& rows) {
  bool complete = true;
  for (const SweepRow& row : rows) {
    if (row.succeeded > 0) continue;
    complete = false;
    std::cerr << "error: no run of " << row.variant << " on " << row.data_set << " succeeded\n";
  }
  return complete;
}

// Default metrics that the data do not show have no column; of others that is worth a warning.
void HandleEmptyMetrics(Experiment* experiment, std::vector<SweepRun>* runs) {
  for (const std::string& name : EmptyMetrics(*experiment, *runs)) {
    if (experiment->has_default_metrics) {
      LeaveOut(name, experiment, runs);
    } else {
      std::cerr << "warning: no run has a value of " << name << "\n";
    }
  }
}

int RunSweepCommand(const std::vector<std::string>& arguments) {
  ExpectArguments(arguments, 1, 1);
  RequireFlag("output_dir");
  Experiment experiment = ReadExperiment(arguments[0], FLAGS_data_dir, CheckFlag);
  const std::string program = std::filesystem::read_symlink("/proc/self/exe").string();
  std::vector<SweepRun> runs = RunSweep(
      experiment, {program, FLAGS_output_dir, FLAGS_threads, ProgressReporter(DrawSweepProgress)});
  HandleEmptyMetrics(&experiment, &runs);
  const std::vector<SweepRow> rows = MakeSweepTable(experiment, runs);
  WriteSweepTables(experiment, runs, rows, {PLANEGRAPH_VERSION, PLANEGRAPH_COMMIT},
                   FLAGS_output_dir);
  const std::size_t reused = Reused(runs);
  nlohmann::json result = {{"name", experiment.name},
                           {"runs", runs.size()},
                           {"carried_out", runs.size() - reused},
                           {"reused", reused},
                           {"failures", FailuresJson(experiment, runs)},
                           {"baseline", experiment.variants[experiment.baseline].name},
                           {"level", experiment.level},
                           {"table", TableJson(experiment, rows)}};
  if (WantsText()) {
    std::printf("%zu runs, %zu of them done before, %zu failed; table: %s/table.html\n",
                runs.size(), reused, result["failures"].size(), FLAGS_output_dir.c_str());
  }
  FLAGS_output = FLAGS_output_dir + "/sweep.json";
  EmitResult(std::move(result), true);
  return Complete(rows) ? 0 : 3;
}

}  // namespace

Command SweepCommand() {
  return {"sweep",
          "EXPERIMENT.yaml --output_dir=DIR",
          "variants of map on data sets, repeated, to one table; --threads: runs at the same time",
          {"output_dir", "data_dir"},
          RunSweepCommand};
}

}  // namespace planegraph::tools
