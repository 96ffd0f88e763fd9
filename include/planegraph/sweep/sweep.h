#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "planegraph/sweep/experiment.h"

namespace planegraph {

struct SweepOptions {
  std::string program;  ///< the planegraph tool
  std::string folder;   ///< for everything that the sweep writes
  int jobs = 0;         ///< runs at the same time; 0: as many as there are cores
  /// Is told which run has ended and what part of all of them (0 to 1).
  std::function<void(const std::string&, double)> progress;
};

/// One run of `map`, and what was measured of it.
struct SweepRun {
  std::size_t data_set = 0, variant = 0;  ///< indices in the experiment
  std::uint64_t seed = 0;
  std::string folder;
  int exit_code = 0;    ///< of `map`, or of the `simulate` before it; 128 + N: ended by signal N
  std::string reason;   ///< the last error of a run that failed
  bool reused = false;  ///< done by an earlier call
  std::vector<std::optional<double>> values;  ///< of the experiment's metrics, in their order

  bool succeeded() const { return exit_code == 0; }
};

/// Carries out an experiment: each run is a process `PROGRAM map ...` in
/// FOLDER/runs/DATASET/VARIANT/SEED, simulated sites are in FOLDER/sites/DATASET/SEED. A run whose
/// record there has the same key (program, flags, seed, input files by size and time of change) is
/// not done again; runs that a signal ended are. The runs are in the order of data sets, seeds and
/// variants. Throws InputError where the tool refuses a variant's flags or files cannot be written,
/// UsageError where another sweep works in the folder.
std::vector<SweepRun> RunSweep(const Experiment& experiment, const SweepOptions& options);

}  // namespace planegraph
