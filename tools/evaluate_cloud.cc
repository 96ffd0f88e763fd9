// MME, MPV and thickness of `planegraph evaluate`: of a map, or of raw scans under poses.
#include <algorithm>
#include <cinttypes>
#include <cmath>
#include <cstdio>

#include "planegraph/base/error.h"
#include "planegraph/evaluation/plane_thickness.h"
#include "planegraph/evaluation/scan_merge.h"
#include "planegraph/evaluation/trajectory_warnings.h"
#include "planegraph/io/cloud_io.h"
#include "planegraph/io/trajectory_io.h"
#include "tools/command.h"
#include "tools/common_flags.h"
#include "tools/evaluate_parts.h"
#include "tools/scan_files.h"

namespace planegraph::tools {
namespace {

// A cloud to judge. Equal fingerprints: the same points, however they are placed.
struct Judged {
  Cloud cloud;
  std::uint64_t fingerprint = 0;
};

Judged MergedScans(const std::string& estimate_file, nlohmann::json* result) {
  const auto [files, format] = FindScans(FLAGS_scans, FLAGS_format);
  const Trajectory estimate = ReadTrajectory(estimate_file);
  NoteWarnings(FileWarnings(estimate, estimate_file), result);
  if (files.size() != estimate.size()) {
    throw InputError::InFile(estimate_file, "has " + std::to_string(estimate.size()) +
                                                " poses for " + std::to_string(files.size()) +
                                                " scans");
  }
  ScanMerger merger({FLAGS_voxel, FLAGS_min_range, FLAGS_max_range});
  for (std::size_t i = 0; i < files.size(); ++i) {
    merger.Add(ReadCloud(files[i], format), estimate.poses[i]);
  }
  return {merger.merged(), merger.fingerprint()};
}

Judged MapCloud() {
  Cloud cloud = ReadCloud(FLAGS_map, FLAGS_format);
  if (FLAGS_voxel > 0.0) cloud = Select(cloud, FirstOfEachVoxel(cloud, FLAGS_voxel));
  const std::uint64_t fingerprint = Fingerprint(cloud);
  return {std::move(cloud), fingerprint};
}

std::string Hexadecimal(std::uint64_t number) {
  char text[20];
  std::snprintf(text, sizeof text, "%016" PRIx64, number);
  return text;
}

// ---- sharpness ----

nlohmann::json Figures(double mme, double mpv) {
  return {{"mme", mme}, {"mpv", FLAGS_mpv ? nlohmann::json(mpv) : nlohmann::json(nullptr)}};
}

nlohmann::json IntervalsJson(const MapQualityIntervals& intervals) {
  if (!intervals.mme) return nullptr;
  return {{"level", FLAGS_confidence},
          {"method", "cubes"},
          {"blocks", intervals.blocks},
          {"mme", ToJson(intervals.mme)},
          {"mpv", ToJson(FLAGS_mpv ? intervals.mpv : std::nullopt)},
          {"thickness_mean", ToJson(intervals.thickness_mean)}};
}

nlohmann::json QualityJson(const MapQuality& quality, const MapQualityIntervals& intervals) {
  nlohmann::json json = Figures(quality.mme, quality.mpv);
  json.update(
      {{"thickness", {{"mean", quality.thickness_mean}, {"median", quality.thickness_median}}},
       {"intervals", IntervalsJson(intervals)},
       {"points", quality.points},
       {"evaluated", quality.evaluated},
       {"used", quality.used},
       {"failed", quality.failed},
       {"mpv_failed", FLAGS_mpv ? nlohmann::json(quality.mpv_failed) : nlohmann::json(nullptr)}});
  return json;
}

void PrintQuality(const MapQuality& quality, const MapQualityIntervals& intervals) {
  std::printf("map quality, mode %s, radius %g m, every %" PRIu64, FLAGS_mode.c_str(), FLAGS_radius,
              FLAGS_every);
  if (FLAGS_mode == "clean") std::printf(", at least %" PRIu64 " neighbours", FLAGS_min_neighbours);
  std::printf("\n  MME        %11.6f nats%s\n", quality.mme, IntervalText(intervals.mme).c_str());
  if (FLAGS_mpv) {
    std::printf("  MPV        %11.6f m%s\n", quality.mpv, IntervalText(intervals.mpv).c_str());
  }
  std::printf("  thickness  %11.6f m mean%s, %.6f m median\n", quality.thickness_mean,
              IntervalText(intervals.thickness_mean).c_str(), quality.thickness_median);
  const char* counted = FLAGS_mode == "tool" ? "counted as 0" : "left out";
  std::printf("  points     %11zu, %zu evaluated, %zu used, %zu failed (%s)", quality.points,
              quality.evaluated, quality.used, quality.failed, counted);
  if (FLAGS_mpv) std::printf("; MPV: %zu without a plane (%s)", quality.mpv_failed, counted);
  std::printf("\n");
}

MapQuality JudgeCloud(const Cloud& cloud, nlohmann::json* json) {
  MapQualityOptions options = MapQualityFlags();
  options.keep_values = FLAGS_confidence > 0.0 || !FLAGS_compare.empty();
  MapQuality quality = ComputeMapQuality(cloud, options);
  MapQualityIntervals intervals;
  if (FLAGS_confidence > 0.0) {
    intervals = ComputeIntervals(cloud, quality, options, FLAGS_confidence);
  }
  json->update(QualityJson(quality, intervals));
  if (WantsText()) PrintQuality(quality, intervals);
  return quality;
}

// ---- two estimates of the same scans ----

nlohmann::json DifferenceJson(const MapQualityDifference& difference) {
  nlohmann::json json = Figures(difference.mme, difference.mpv);
  json.update({{"thickness_mean", difference.thickness_mean},
               {"points", difference.points},
               {"intervals", FLAGS_confidence > 0.0 ? IntervalsJson(difference.intervals)
                                                    : nlohmann::json(nullptr)}});
  return json;
}

void PrintDifference(const MapQualityDifference& difference) {
  const bool wanted = FLAGS_confidence > 0.0;
  const auto text = [&](const auto& interval) {
    return wanted ? IntervalText(interval) : std::string();
  };
  std::printf("%s less %s, over the %zu points that both use\n", FLAGS_compare.c_str(),
              FLAGS_estimate.c_str(), difference.points);
  std::printf("  MME        %+11.6f nats%s\n", difference.mme,
              text(difference.intervals.mme).c_str());
  if (FLAGS_mpv) {
    std::printf("  MPV        %+11.6f m%s\n", difference.mpv,
                text(difference.intervals.mpv).c_str());
  }
  std::printf("  thickness  %+11.6f m mean%s\n", difference.thickness_mean,
              text(difference.intervals.thickness_mean).c_str());
}

// The points that stay of each scan do not depend on the poses; the fingerprints prove it.
void ReportComparison(const Judged& judged, const MapQuality& quality, nlohmann::json* result) {
  const Judged other = MergedScans(FLAGS_compare, result);
  if (other.fingerprint != judged.fingerprint) {
    throw InputError::InFile(FLAGS_compare, "leads to other points than " + FLAGS_estimate +
                                                ": they cannot be compared");
  }
  nlohmann::json compare = (*result)["compare"];
  if (!compare.is_object()) compare = nlohmann::json::object();
  compare["estimate"] = FLAGS_compare;
  if (WantsText()) std::printf("the same of %s\n", FLAGS_compare.c_str());
  const MapQuality of_other = JudgeCloud(other.cloud, &compare);
  const double level = FLAGS_confidence > 0.0 ? FLAGS_confidence : IntervalOptions().level;
  const auto difference = CompareQuality(judged.cloud, quality, of_other, MapQualityFlags(), level);
  compare["difference"].update(DifferenceJson(difference));
  (*result)["compare"] = std::move(compare);
  if (WantsText()) PrintDifference(difference);
}

void ReportQuality(const Judged& judged, nlohmann::json* result) {
  result->update({{"radius", FLAGS_radius},
                  {"mode", FLAGS_mode},
                  {"every", FLAGS_every},
                  {"min_neighbours", FLAGS_min_neighbours},
                  {"voxel", FLAGS_voxel},
                  {"point_set", Hexadecimal(judged.fingerprint)}});
  const MapQuality quality = JudgeCloud(judged.cloud, result);
  if (!FLAGS_compare.empty() && !FLAGS_scans.empty()) ReportComparison(judged, quality, result);
}

// ---- planes ----

nlohmann::json Number(double value) {
  return std::isfinite(value) ? nlohmann::json(value) : nlohmann::json(nullptr);
}

nlohmann::json LandmarkJson(const LandmarkThickness& landmark) {
  return {{"scan", landmark.scan},
          {"plane", landmark.plane},
          {"scans", landmark.scans},
          {"points", landmark.laser_on_laser.points},
          {"laser_on_laser", Number(landmark.laser_on_laser.Rms())},
          {"within_scans", Number(landmark.within_scans.Rms())},
          {"map_points", landmark.map_on_laser.points},
          {"map_on_laser", Number(landmark.map_on_laser.Rms())}};
}

nlohmann::json ThicknessJson(const PlaneThickness& thickness) {
  nlohmann::json landmarks = nlohmann::json::array();
  for (const auto& landmark : thickness.landmarks) landmarks.push_back(LandmarkJson(landmark));
  return {{"laser_on_laser",
           {{"rms", Number(thickness.laser_on_laser.Rms())},
            {"interval", ToJson(thickness.laser_interval)},
            {"median", Number(thickness.laser_median)},
            {"within_scans", Number(thickness.within_scans.Rms())},
            {"points", thickness.laser_on_laser.points}}},
          {"map_on_laser",
           {{"rms", Number(thickness.map_on_laser.Rms())},
            {"interval", ToJson(thickness.map_interval)},
            {"median", Number(thickness.map_median)},
            {"points", thickness.map_on_laser.points}}},
          {"level", FLAGS_confidence},
          {"landmarks", std::move(landmarks)}};
}

void PrintThickness(const PlaneThickness& thickness) {
  const auto several = std::count_if(thickness.landmarks.begin(), thickness.landmarks.end(),
                                     [](const auto& landmark) { return landmark.scans > 1; });
  std::printf("plane thickness, %zu landmarks, %td of them from several scans\n",
              thickness.landmarks.size(), several);
  if (thickness.laser_on_laser.points > 0.0) {
    std::printf("  laser on laser %9.6f m rms%s, %.6f m median; %.6f m rms within scans\n",
                thickness.laser_on_laser.Rms(), IntervalText(thickness.laser_interval).c_str(),
                thickness.laser_median, thickness.within_scans.Rms());
  }
  if (thickness.map_on_laser.points > 0.0) {
    std::printf("  map on laser   %9.6f m rms%s, %.6f m median\n", thickness.map_on_laser.Rms(),
                IntervalText(thickness.map_interval).c_str(), thickness.map_median);
  }
}

void ReportThickness(nlohmann::json* result) {
  const auto labelled = ReadLabelledCloud(FLAGS_map);
  if (!labelled) return;
  const bool wants_interval = FLAGS_confidence > 0.0;
  PlaneThickness thickness = ComputePlaneThickness(
      *labelled, {}, wants_interval ? FLAGS_confidence : IntervalOptions().level);
  if (!wants_interval) thickness.laser_interval = thickness.map_interval = std::nullopt;
  if (thickness.landmarks.empty()) return;
  (*result)["planes"] = ThicknessJson(thickness);
  if (WantsText()) PrintThickness(thickness);
}

}  // namespace

void ReportClouds(nlohmann::json* result) try {
  const bool is_map = !FLAGS_map.empty();
  ReportQuality(is_map ? MapCloud() : MergedScans(FLAGS_estimate, result), result);
  if (is_map) ReportThickness(result);
} catch (const NoResultError& error) {
  NoteFailure("mme", error.what(), result);
}

}  // namespace planegraph::tools
