// `planegraph evaluate`: errors of a trajectory against a reference, sharpness of a map or of raw
// scans under given poses.
#include <gflags/gflags.h>

#include <cmath>
#include <cstdio>
#include <string>

#include "planegraph/base/error.h"
#include "planegraph/evaluation/map_quality.h"
#include "planegraph/evaluation/scan_merge.h"
#include "planegraph/evaluation/trajectory_error.h"
#include "planegraph/io/cloud_io.h"
#include "planegraph/io/trajectory_io.h"
#include "tools/command.h"
#include "tools/common_flags.h"
#include "tools/scan_files.h"

DEFINE_string(reference, "", "trajectory to compare with");
DEFINE_string(estimate, "", "trajectory to judge; with --scans, the poses of the scans");
DEFINE_string(align, "se3", "alignment of the estimate before ATE: se3, sim3, first, none");
DEFINE_double(delta, 1.0, "distance between the poses of an RPE pair");
DEFINE_string(delta_unit, "frames", "unit of --delta: frames, m");
DEFINE_string(pairs, "consecutive", "RPE pairs: consecutive (disjoint), all (one from each pose)");
DEFINE_string(pairs_from, "reference", "whose path counts the metres: reference, estimate");
DEFINE_double(max_time_difference, 0.01, "of two poses that belong together, seconds");
DEFINE_string(map, "", "cloud: evaluate: of a merged map; locate: of the drone map");
DEFINE_string(scans, "", "raw scans (a glob in name order, or a folder) to lay under --estimate");
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

constexpr int kNoResult = 3;

nlohmann::json ToJson(const Statistics& s) {
  return {{"rmse", s.rmse}, {"mean", s.mean}, {"median", s.median},
          {"std", s.std},   {"min", s.min},   {"max", s.max}};
}

nlohmann::json ToJson(const PoseErrors& errors) {
  nlohmann::json json = ToJson(errors.translation);
  json["rotation"] = ToJson(errors.rotation);
  json["count"] = errors.count;
  return json;
}

bool IsFirst(const std::string& flag, const std::string& value, const std::string& first,
             const std::string& second) {
  if (value != first && value != second) {
    throw UsageError("--" + flag + " is " + first + " or " + second + ", not '" + value + "'");
  }
  return value == first;
}

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

// What is known is written even where a part of it has no result; the reasons go along.
void NoteFailure(const std::string& what, const std::string& reason, nlohmann::json* result) {
  (*result)[what] = nullptr;
  (*result)["reason"].push_back(what + ": " + reason);
  std::fprintf(stderr, "error: %s: %s\n", what.c_str(), reason.c_str());
}

void PrintRow(const char* name, const Statistics& s, double factor) {
  std::printf("  %-18s %11.6f %11.6f %11.6f %11.6f %11.6f %11.6f\n", name, factor * s.rmse,
              factor * s.mean, factor * s.median, factor * s.std, factor * s.min, factor * s.max);
}

void PrintErrors(const PoseErrors& errors) {
  constexpr double kDegrees = 180.0 / M_PI;
  std::printf("  %-18s %11s %11s %11s %11s %11s %11s\n", "", "rmse", "mean", "median", "std", "min",
              "max");
  PrintRow("translation [m]", errors.translation, 1.0);
  PrintRow("rotation [rad]", errors.rotation, 1.0);
  PrintRow("rotation [deg]", errors.rotation, kDegrees);
}

void PrintPairing(const PosePairs& pairs) {
  std::printf("%zu pairs of poses by %s", pairs.reference.size(), pairs.by_time ? "time" : "index");
  if (pairs.by_time) std::printf(", largest time difference %.6f s", pairs.max_time_difference);
  std::printf("\n");
}

// Returns the scale of the alignment, which RPE takes over.
double ReportAte(const PosePairs& pairs, nlohmann::json* result) try {
  const AteResult ate = ComputeAte(pairs, ParsePoseAlignment(FLAGS_align));
  (*result)["ate"] = ToJson(ate.errors);
  (*result)["ate"]["alignment"] = FLAGS_align;
  const Sim3& sim = ate.reference_from_estimate;
  const auto& q = sim.rotation.coeffs();
  (*result)["ate"]["reference_from_estimate"] = {
      {"scale", sim.scale},
      {"rotation", {q.x(), q.y(), q.z(), q.w()}},
      {"translation", {sim.translation.x(), sim.translation.y(), sim.translation.z()}}};
  if (WantsText()) {
    std::printf("ATE, alignment %s (scale %.6f), %zu poses\n", FLAGS_align.c_str(), sim.scale,
                ate.errors.count);
    PrintErrors(ate.errors);
  }
  return sim.scale;
} catch (const NoResultError& error) {
  NoteFailure("ate", error.what(), result);
  return 1.0;
}

void ReportRpe(const PosePairs& pairs, double scale, nlohmann::json* result) try {
  const RpeResult rpe = ComputeRpe(pairs, RpeFlags(), scale);
  (*result)["rpe"] = ToJson(rpe.errors);
  (*result)["rpe"].update({{"delta", FLAGS_delta},
                           {"delta_unit", FLAGS_delta_unit},
                           {"pairs", FLAGS_pairs},
                           {"pairs_from", FLAGS_pairs_from},
                           {"alignment", FLAGS_align}});
  if (!WantsText()) return;
  std::printf("RPE, delta %g %s, pairs %s, chosen on the %s, scale %.6f, %zu pairs\n", FLAGS_delta,
              FLAGS_delta_unit.c_str(), FLAGS_pairs.c_str(), FLAGS_pairs_from.c_str(), scale,
              rpe.errors.count);
  PrintErrors(rpe.errors);
} catch (const NoResultError& error) {
  NoteFailure("rpe", error.what(), result);
}

void ReportTrajectory(nlohmann::json* result) {
  const PosePairs pairs = PairPoses(ReadTrajectory(FLAGS_reference), ReadTrajectory(FLAGS_estimate),
                                    FLAGS_max_time_difference, FLAGS_estimate);
  (*result)["paired_by"] = pairs.by_time ? "time" : "index";
  (*result)["max_time_difference"] = pairs.max_time_difference;
  if (WantsText()) PrintPairing(pairs);
  ReportRpe(pairs, ReportAte(pairs, result), result);
  for (const char* key : {"delta", "delta_unit", "pairs", "pairs_from"}) {
    if (!(*result)["rpe"].is_null()) (*result)[key] = (*result)["rpe"][key];
  }
  (*result)["alignment"] = FLAGS_align;
  (*result)["count"] = pairs.reference.size();
}

Cloud MergedScans() {
  const std::vector<std::string> files = ScanFiles(FLAGS_scans, FLAGS_format);
  const Trajectory estimate = ReadTrajectory(FLAGS_estimate);
  if (files.size() != estimate.size()) {
    throw InputError::InFile(FLAGS_estimate, "has " + std::to_string(estimate.size()) +
                                                 " poses for " + std::to_string(files.size()) +
                                                 " scans");
  }
  ScanMerger merger({FLAGS_voxel, FLAGS_min_range, FLAGS_max_range});
  for (std::size_t i = 0; i < files.size(); ++i) {
    merger.Add(ReadCloud(files[i], FLAGS_format), estimate.poses[i]);
  }
  return merger.merged();
}

Cloud MapCloud() {
  const Cloud cloud = ReadCloud(FLAGS_map, FLAGS_format);
  return FLAGS_voxel > 0.0 ? Select(cloud, FirstOfEachVoxel(cloud, FLAGS_voxel)) : cloud;
}

void PrintQuality(const MapQuality& quality) {
  std::printf("map quality, mode %s, radius %g m, every %llu, at least %llu neighbours\n",
              FLAGS_mode.c_str(), FLAGS_radius, static_cast<unsigned long long>(FLAGS_every),
              static_cast<unsigned long long>(FLAGS_min_neighbours));
  std::printf("  MME        %11.6f nats\n", quality.mme);
  if (FLAGS_mpv) std::printf("  MPV        %11.6f m\n", quality.mpv);
  std::printf("  thickness  %11.6f m mean, %.6f m median\n", quality.thickness_mean,
              quality.thickness_median);
  std::printf("  points     %11zu, %zu evaluated, %zu used, %zu failed\n", quality.points,
              quality.evaluated, quality.used, quality.failed);
}

void ReportQuality(const Cloud& cloud, nlohmann::json* result) try {
  const MapQuality quality = ComputeMapQuality(cloud, MapQualityFlags());
  result->update(
      {{"mme", quality.mme},
       {"mpv", FLAGS_mpv ? nlohmann::json(quality.mpv) : nlohmann::json(nullptr)},
       {"thickness", {{"mean", quality.thickness_mean}, {"median", quality.thickness_median}}},
       {"radius", FLAGS_radius},
       {"mode", FLAGS_mode},
       {"every", FLAGS_every},
       {"min_neighbours", FLAGS_min_neighbours},
       {"voxel", FLAGS_voxel},
       {"points", quality.points},
       {"evaluated", quality.evaluated},
       {"used", quality.used},
       {"failed", quality.failed}});
  if (WantsText()) PrintQuality(quality);
} catch (const NoResultError& error) {
  NoteFailure("mme", error.what(), result);
}

// Wrong values are told before anything is read.
void CheckFlags() {
  const bool trajectory = !FLAGS_reference.empty(), scans = !FLAGS_scans.empty();
  const bool map = !FLAGS_map.empty();
  if (!trajectory && !scans && !map) {
    throw UsageError("evaluate needs --reference and --estimate, --map, or --scans and --estimate");
  }
  if (scans && map) throw UsageError("--map and --scans exclude each other");
  if (trajectory || scans) RequireFlag("estimate");
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
  CheckFlags();
  nlohmann::json result = nlohmann::json::object();
  if (!FLAGS_reference.empty()) ReportTrajectory(&result);
  if (!FLAGS_map.empty()) ReportQuality(MapCloud(), &result);
  if (!FLAGS_scans.empty()) ReportQuality(MergedScans(), &result);
  const bool complete = !result.contains("reason");
  EmitResult(std::move(result), true);
  return complete ? 0 : kNoResult;
}

}  // namespace

Command EvaluateCommand() {
  return {
      "evaluate",
      "",
      "errors of a trajectory (ATE, RPE); sharpness of a map (MME, MPV, thickness)",
      {"reference",           "estimate", "align", "delta",     "delta_unit", "pairs", "pairs_from",
       "max_time_difference", "map",      "scans", "format",    "radius",     "voxel", "every",
       "min_neighbours",      "mode",     "mpv",   "min_range", "max_range",  "output"},
      RunEvaluate};
}

}  // namespace planegraph::tools
