// `planegraph evaluate`: errors of a trajectory against a reference, sharpness of a map or of raw
// scans under given poses.
#include <gflags/gflags.h>

#include <algorithm>
#include <cstdio>
#include <string>

#include "planegraph/base/error.h"
#include "tools/command.h"
#include "tools/common_flags.h"
#include "tools/evaluate_parts.h"
#include "tools/gnuplot.h"

DEFINE_string(reference, "", "trajectory to compare with");
DEFINE_string(estimate, "", "trajectory to judge; with --scans, the poses of the scans");
DEFINE_string(compare, "", "second estimate of the same scans or reference, beside the first");
DEFINE_string(plot, "", "draws trajectories and errors: FILE.svg or FILE.pdf (by gnuplot)");
DEFINE_double(confidence, 0.95, "level of the intervals (jackknife over blocks); 0: none");
DEFINE_string(align, "se3", "alignment of the estimate before ATE: se3, sim3, first, none");
DEFINE_double(delta, 1.0, "distance between the poses of an RPE pair");
DEFINE_string(delta_unit, "frames", "unit of --delta: frames, m");
DEFINE_string(pairs, "consecutive", "RPE pairs: consecutive (disjoint), all (one from each pose)");
DEFINE_string(pairs_from, "reference", "whose path counts the metres: reference, estimate");
DEFINE_double(max_time_difference, 0.01, "of two poses that belong together, seconds");
DEFINE_string(map, "", "cloud: evaluate: of a merged map; locate: of the drone map");
DEFINE_string(scans, "",
              "raw scans (a glob in name order, a folder, or a site file of one robot) to lay "
              "under --estimate");
DEFINE_double(radius, 0.3, "of the neighbourhoods for MME, MPV and thickness, metres");
DEFINE_double(voxel, 0.0,
              "thins each scan (or the map) to one point per voxel of this edge; 0: none");
DEFINE_uint64(every, 1, "evaluates every k-th point");
DEFINE_uint64(min_neighbours, 15, "least points of a neighbourhood (mode clean)");
DEFINE_string(mode, "clean",
              "clean: leave failed neighbourhoods out; tool: count as Razlaw's tool");
DEFINE_bool(mpv, true, "compute MPV, which takes most of the time");
DEFINE_double(max_range, 0.0, "points of scans farther from the scanner are dropped; 0: none");

namespace planegraph::tools {
namespace {

bool IsFirst(const std::string& flag, const std::string& value, const std::string& first,
             const std::string& second) {
  if (value != first && value != second) {
    throw UsageError("--" + flag + " is " + first + " or " + second + ", not '" + value + "'");
  }
  return value == first;
}

}  // namespace

RpeOptions RpeFlags() {
  RpeOptions options;
  options.delta = FLAGS_delta;
  options.unit = IsFirst("delta_unit", FLAGS_delta_unit, "frames", "m") ? DeltaUnit::kFrames
                                                                        : DeltaUnit::kMetres;
  options.all_pairs = !IsFirst("pairs", FLAGS_pairs, "consecutive", "all");
  options.pairs_from_estimate = !IsFirst("pairs_from", FLAGS_pairs_from, "reference", "estimate");
  return options;
}

MapQualityOptions MapQualityFlags() {
  MapQualityOptions options;
  options.radius = FLAGS_radius;
  options.every = FLAGS_every;
  options.min_neighbours = FLAGS_min_neighbours;
  options.mode = ParseMapQualityMode(FLAGS_mode);
  options.plane_variance = FLAGS_mpv;
  options.seed = FLAGS_seed;
  options.threads = FLAGS_threads;
  return options;
}

void NoteFailure(const std::string& what, const std::string& reason, nlohmann::json* result) {
  (*result)[what] = nullptr;
  (*result)["reason"].push_back(what + ": " + reason);
  std::fprintf(stderr, "error: %s: %s\n", what.c_str(), reason.c_str());
}

void NoteWarnings(const std::vector<std::string>& warnings, nlohmann::json* result) {
  nlohmann::json& all = (*result)["warnings"];
  for (const std::string& warning : warnings) {
    if (std::find(all.begin(), all.end(), warning) != all.end()) continue;
    all.push_back(warning);
    if (!FLAGS_quiet) std::fprintf(stderr, "warning: %s\n", warning.c_str());
  }
}

nlohmann::json ToJson(const std::optional<Interval>& interval) {
  return interval ? nlohmann::json{interval->low, interval->high} : nlohmann::json(nullptr);
}

std::string IntervalText(const std::optional<Interval>& interval, double factor) {
  if (!interval) return "";
  char text[120];
  std::snprintf(text, sizeof text, " (%g %%: %.6f to %.6f)", 100.0 * FLAGS_confidence,
                factor * interval->low, factor * interval->high);
  return text;
}

namespace {

// Wrong values are told before anything is read.
void CheckEvaluateFlags() {
  const bool trajectory = !FLAGS_reference.empty(), scans = !FLAGS_scans.empty();
  const bool map = !FLAGS_map.empty();
  if (!trajectory && !scans && !map) {
    throw UsageError("evaluate needs --reference and --estimate, --map, or --scans and --estimate");
  }
  if (scans && map) throw UsageError("--map and --scans exclude each other");
  if (trajectory || scans) RequireFlag("estimate");
  if (!FLAGS_compare.empty() && !trajectory && !scans) {
    throw UsageError("--compare goes with --reference or --scans: maps are not the same points");
  }
  if (!FLAGS_plot.empty() && !trajectory) throw UsageError("--plot needs --reference");
  if (!FLAGS_plot.empty()) PlotFormat(FLAGS_plot);
  if (!(FLAGS_confidence >= 0.0 && FLAGS_confidence < 1.0)) {
    throw UsageError("--confidence lies in [0, 1)");
  }
  ParsePoseAlignment(FLAGS_align);
  SelectPairs({}, RpeFlags());
  MapQualityFlags();
  if (!(FLAGS_radius > 0.0)) throw UsageError("--radius must be above 0");
  if (FLAGS_every == 0) throw UsageError("--every must be at least 1");
  for (double value : {FLAGS_voxel, FLAGS_min_range, FLAGS_max_range, FLAGS_max_time_difference}) {
    if (!(value >= 0.0)) {
      throw UsageError("--voxel, ranges and --max_time_difference must not be negative");
    }
  }
}

int RunEvaluate(const std::vector<std::string>& arguments) {
  ExpectArguments(arguments, 0, 0);
  CheckEvaluateFlags();
  nlohmann::json result = {{"warnings", nlohmann::json::array()}};
  if (!FLAGS_reference.empty()) ReportTrajectory(&result);
  if (!FLAGS_map.empty() || !FLAGS_scans.empty()) ReportClouds(&result);
  const bool complete = !result.contains("reason");
  EmitResult(std::move(result), true);
  return complete ? 0 : kNoResult;
}

}  // namespace

Command EvaluateCommand() {
  return {"evaluate",
          "",
          "errors of a trajectory (ATE, RPE); sharpness of a map (MME, MPV, thickness of planes)",
          {"reference",
           "estimate",
           "compare",
           "plot",
           "confidence",
           "align",
           "delta",
           "delta_unit",
           "pairs",
           "pairs_from",
           "max_time_difference",
           "map",
           "scans",
           "format",
           "radius",
           "voxel",
           "every",
           "min_neighbours",
           "mode",
           "mpv",
           "min_range",
           "max_range",
           "output"},
          RunEvaluate};
}

}  // namespace planegraph::tools
