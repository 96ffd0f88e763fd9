#pragma once

#include <optional>
#include <string>
#include <vector>

#include "planegraph/sweep/experiment.h"
#include "sweep/stage.h"

namespace planegraph {

/// The metric that the tool knows by this name.
std::optional<SweepMetric> BuiltinMetric(const std::string& name);
/// Their names, with commas between them.
std::string BuiltinMetricNames();
/// What is measured where an experiment does not say.
std::vector<SweepMetric> DefaultMetrics();

/// The aggregate of this name.
std::optional<Aggregate> ParseAggregate(const std::string& name);
/// Why a text is no JSON pointer (RFC 6901); empty where it is one.
std::string PointerError(const std::string& pointer);

/// Whether one of the metrics needs the map's sharpness (`evaluate --map`).
bool NeedsSharpness(const std::vector<SweepMetric>& metrics);

/// Where the figures of a run are.
struct RunFiles {
  std::string folder;  ///< report.json, evaluate.json
  std::string truth;   ///< JSON file with the drone maps' true scale; may be empty
};

/// The value of every metric; nothing where the run has none.
std::vector<std::optional<double>> Measure(const std::vector<SweepMetric>& metrics,
                                           const RunFiles& files, const StageRecord& record);

}  // namespace planegraph
