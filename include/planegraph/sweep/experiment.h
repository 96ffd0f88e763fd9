#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <string>
#include <vector>

namespace planegraph {

/// Flags of a command with their values as text, by name and without dashes.
using FlagValues = std::map<std::string, std::string>;

/// What is mapped: a site file, or a simulated site for each seed.
struct SweepDataSet {
  std::string name;
  std::string site;      ///< the site file; empty: simulated
  FlagValues simulate;   ///< flags of `simulate`
  std::string map_file;  ///< of a simulated site: the site file that is mapped, in its folder
  std::string truth;     ///< JSON file with the true `scale` of the drone maps; may be empty
  std::vector<std::uint64_t> seeds;
  std::size_t line = 0;  ///< in the experiment's file

  bool is_simulated() const { return site.empty(); }
};

/// How it is mapped.
struct SweepVariant {
  std::string name;
  FlagValues flags;  ///< of `map`
  std::size_t line = 0;
};

/// How several numbers of one run become one.
enum class Aggregate { kMean, kMedian, kMax, kMin, kSum, kCount };

/// What is measured of a run.
struct SweepMetric {
  std::string name, unit;
  std::string
      pointer;  ///< JSON pointer into report.json, where `*` is every member; empty: built in
  Aggregate aggregate = Aggregate::kMean;
  bool is_ratio = false;  ///< compared by quotients (times, memory), not by differences
};

/// An experiment: every variant on every data set with each of its seeds.
struct Experiment {
  std::string path;  ///< of its file
  std::string name;
  std::vector<SweepDataSet> data_sets;
  std::vector<SweepVariant> variants;
  std::vector<SweepMetric> metrics;
  bool has_default_metrics = false;  ///< the file names none
  std::size_t baseline = 0;          ///< the variant that the others are compared with
  int threads = 1;                   ///< of each run
  double level = 0.95;               ///< of intervals and tests
  bool keeps_everything = true;      ///< else logs and JSON results alone
};

/// Why a flag of a command (`map`, `simulate`) cannot have that value; empty where it can.
using FlagCheck = std::function<std::string(const std::string& command, const std::string& flag,
                                            const std::string& value)>;

/// Reads EXPERIMENT.yaml (docs/sweep.md). Site files are relative to `data_folder`, or to the
/// experiment's file where that is empty. Unknown keys, metrics and flags, missing files, names
/// that are taken and seeds that are no numbers are InputErrors that name the line.
Experiment ReadExperiment(const std::string& path, const std::string& data_folder,
                          const FlagCheck& check);

}  // namespace planegraph
