// planegraph map: scans (and drone maps) to one consistent map.
#include <gflags/gflags.h>

#include <algorithm>
#include <iostream>
#include <sstream>

#include "planegraph/base/angles.h"
#include "planegraph/base/atomic_file.h"
#include "planegraph/base/counted.h"
#include "planegraph/base/error.h"
#include "planegraph/graph/factor_losses.h"
#include "planegraph/pipeline/mapper.h"
#include "planegraph/pipeline/outputs.h"
#include "planegraph/report/apart.h"
#include "planegraph/report/html_report.h"
#include "tools/command.h"
#include "tools/common_flags.h"
#include "tools/map_memory.h"
#include "tools/progress.h"

DEFINE_string(optimizer, "graph", "graph (joint), metascan (the paper's), none (pairwise chain)");
DEFINE_string(plane_factor, "moments",
              "cost variant of the planes, NAME[:OPTION=VALUE,...] (see `planegraph factors`)");
DEFINE_string(loss, "cauchy:2.4",
              "robust loss of the planes' residuals (optimize: of the edges', none by default), "
              "NAME[:SCALE][,FACTOR=NAME[:SCALE]...]: none, huber, soft_l1, cauchy, "
              "tukey, geman_mcclure, dcs; gnc_tls, gnc_gm (graduated non-convexity); after it "
              "other losses for factors by their names (see `planegraph factors`), say "
              "relative_pose=huber:2");
DEFINE_string(
    covariance, "residuals",
    "what says how large the noise is behind the sigmas of the report: residuals (of each "
    "surface), stated (the noise model alone)");
DEFINE_double(map_tiles, 0.0,
              "edge of the tiles that each drone map is cut into because it is bent, metres, in "
              "place of the site's `tiles: {size}` (0: as the site says)");
DEFINE_double(map_voxel, 0.05,
              "voxel of the merged map, metres: of each scan one point stays (0: all points)");

namespace planegraph::tools {

Command MapCommand();

namespace {

MapOptions MapOptionsFromFlags() {
  MapOptions options;
  options.optimizer = FLAGS_optimizer;
  const FactorChoice factor = BuiltinFactors().Parse(FLAGS_plane_factor, FactorKind::kPlane);
  options.plane_factor = factor.name;
  options.plane_factor_options = factor.options;
  const FactorLosses losses = ParseFactorLosses(FLAGS_loss, options.loss, BuiltinFactors());
  options.loss = losses.general;
  options.factor_losses = losses.by_type;
  options.covariance = ParseCovarianceNoise(FLAGS_covariance);
  options.threads = FLAGS_threads;
  options.map_memory = MapMemoryFromFlags(FLAGS_output_dir);
  return options;
}

void DrawProgress(const std::string& stage, double done) {
  const int filled = static_cast<int>(30 * std::min(done, 1.0));
  std::cerr << "\r" << stage << std::string(14 - std::min<std::size_t>(stage.size(), 13), ' ')
            << "[" << std::string(filled, '#') << std::string(30 - filled, ' ') << "]"
            << (done >= 1.0 ? "\n" : "") << std::flush;
}

nlohmann::json WriteReport(const MapResult& result, const MapOptions& options,
                           const std::string& folder) {
  nlohmann::json report = nlohmann::json::parse(ReportJson(result, options));
  report["planegraph"] = VersionStamp();
  report["seconds"] = SecondsSinceStart();
  WriteTextFile(folder + "/report.json", report.dump(1) + "\n");
  WriteHtmlReport(folder);
  WriteTextFile(folder + "/run.flags", FlagFile(MapCommand().flags));
  if (FLAGS_json) std::cout << report.dump() << "\n";
  return report;
}

void PrintEvaluation(const nlohmann::json& evaluation) {
  for (const auto& [robot, e] : evaluation.items()) {
    std::printf("%s against its reference: ATE %.4f m (%s)", robot.c_str(),
                e["ate"]["rmse"].get<double>(), e["ate"]["alignment"].get<std::string>().c_str());
    if (e.contains("rpe")) {
      std::printf(", RPE %.4f m / %.3f deg", e["rpe"]["rmse"].get<double>(),
                  e["rpe"]["rotation"]["rmse"].get<double>() * kDegreesPerRadian);
    }
    std::printf("\n");
  }
}

std::size_t Anchored(const MapResult& result, std::size_t map) {
  std::size_t count = 0;
  for (const auto& pair : result.map_pairs) count += pair.used && pair.map == map ? 1 : 0;
  return count;
}

void PrintMaps(const MapResult& result, const nlohmann::json& report) {
  for (std::size_t m = 0; m < result.maps.size(); ++m) {
    const nlohmann::json& map = report["maps"][m];
    std::printf("drone map %s: %zu of %zu scans anchored, %.6f m per unit",
                result.maps[m].id.c_str(), Anchored(result, m), result.scans.size(),
                map["world_from_map"]["scale"].get<double>());
    if (map["sigma_scale"].is_number()) {
      std::printf(" (sigma %.2f %%)", 100.0 * map["sigma_scale"].get<double>());
    }
    std::printf("\n");
  }
}

// One line: who they are; why is in the report.
void PrintSwitchedOff(const nlohmann::json& list) {
  if (list.empty()) return;
  std::ostringstream names;
  for (std::size_t k = 0; k < std::min<std::size_t>(list.size(), 5); ++k) {
    names << (k > 0 ? ", " : "") << list[k]["kind"].get<std::string>() << " "
          << list[k]["target"].get<std::string>();
    if (list[k]["source"].is_string()) names << "-" << list[k]["source"].get<std::string>();
  }
  std::printf("%zu switched off: %s%s\n", list.size(), names.str().c_str(),
              list.size() > 5 ? ", ..." : "");
}

// What the planes leave open, each motion once for all scans that share it.
void PrintOpenMotions(const nlohmann::json& observability) {
  if (!observability.is_object()) return;
  for (const auto& motion : observability["motions"]) {
    std::printf("%s\n", motion["text"].get<std::string>().c_str());
  }
}

// "22 of 25 registrations between scans and 6 of 9 to drone maps used"
std::string RegistrationsText(const MapResult& result) {
  std::size_t used = 0, used_maps = 0;
  for (const auto& pair : result.pairs) used += pair.used ? 1 : 0;
  for (const auto& pair : result.map_pairs) used_maps += pair.used ? 1 : 0;
  std::string text = std::to_string(used) + " of " + Counted(result.pairs.size(), "registration") +
                     " between scans";
  if (!result.maps.empty()) {
    text += " and " + std::to_string(used_maps) + " of " + std::to_string(result.map_pairs.size()) +
            " to drone maps";
  }
  return text + " used";
}

void PrintSummary(const MapResult& result, const nlohmann::json& report) {
  std::printf("%s, %s, %s, %.1f s\n", Counted(result.scans.size(), "scan").c_str(),
              RegistrationsText(result).c_str(),
              Counted(static_cast<std::size_t>(result.components), "component").c_str(),
              SecondsSinceStart());
  PrintSwitchedOff(report["switched_off"]);
  PrintMaps(result, report);
  PrintOpenMotions(report["observability"]);
  PrintEvaluation(report["evaluation"]);
  std::printf("results: %s\n", FLAGS_output_dir.c_str());
}

bool Converged(const MapResult& result) {
  return FLAGS_optimizer != "graph" || result.solution.summary.converged;
}

// The first reason why no scan was found in a map.
std::string ReasonOf(const MapResult& result, std::size_t map) {
  for (const auto& pair : result.map_pairs) {
    if (pair.map == map && !pair.reason.empty()) return pair.reason;
  }
  return "no scan was tried";
}

// Whether every drone map holds a scan; says of the others why not.
bool MapsJoined(const MapResult& result) {
  bool joined = true;
  for (std::size_t m = 0; m < result.maps.size(); ++m) {
    if (Anchored(result, m) > 0) continue;
    joined = false;
    std::cerr << "error: no scan was found in the drone map " << result.maps[m].id << ": "
              << ReasonOf(result, m) << "\n";
  }
  return joined;
}

std::string ApartText(const MapResult& result) {
  std::vector<ComponentScan> scans;
  for (std::size_t i = 0; i < result.scans.size(); ++i) {
    scans.push_back({result.scans[i].id, result.component[i]});
  }
  return ApartText(scans);
}

// All scans and maps in one component is what the map was asked for.
int ExitCode(const MapResult& result, const nlohmann::json& report) {
  // The others were said when they arose.
  for (const auto& warning : report["warnings"]) {
    const auto text = warning.get<std::string>();
    if (!std::count(result.warnings.begin(), result.warnings.end(), text)) PrintWarning(text);
  }
  const bool joined = MapsJoined(result);
  if (joined && result.components <= 1 && Converged(result)) return 0;
  if (result.components > 1) {
    std::cerr << "error: the scans do not form one component but " << result.components << ": "
              << ApartText(result) << "; " << FLAGS_output_dir << "/report.html says why\n";
  }
  if (!Converged(result)) {
    std::cerr << "error: the joint solve did not come to rest: its last step moved a scan by "
              << result.solution.last_move << " m\n";
  }
  return kNoResult;
}

void CutMapsAsFlagged(Site* site) {
  if (FLAGS_map_tiles == 0.0) return;
  for (DroneMapSite& map : site->maps) {
    if (!map.tiles) map.tiles.emplace();
    map.tiles->size = FLAGS_map_tiles;
  }
}

int RunMap(const std::vector<std::string>& arguments) {
  ExpectArguments(arguments, 1, 1);
  RequireFlag("output_dir");
  if (FLAGS_map_tiles != 0.0 && !(FLAGS_map_tiles >= MapTiling::kLeastSize)) {
    throw UsageError("--map_tiles must be at least 1 m (0: as the site says)");
  }
  MapOptions options = MapOptionsFromFlags();
  options.progress = ProgressReporter(DrawProgress);
  options.warn = PrintWarning;
  Site site = ReadSite(arguments[0]);
  CutMapsAsFlagged(&site);
  CreateFolder(FLAGS_output_dir);
  MapResult result = MapScans(site, options);
  const double before = SecondsSinceStart();
  options.progress("output", 0.0);
  WriteOutputs(result, {FLAGS_output_dir, FLAGS_map_voxel, FLAGS_threads});
  result.seconds.output = SecondsSinceStart() - before;
  const nlohmann::json report = WriteReport(result, options, FLAGS_output_dir);
  options.progress("output", 1.0);
  if (WantsText()) PrintSummary(result, report);
  return ExitCode(result, report);
}

}  // namespace

Command MapCommand() {
  return {"map",
          "SITE.yaml",
          "scans to one consistent map: poses, merged map, report",
          {"output_dir", "optimizer", "plane_factor", "loss", "covariance", "map_voxel",
           "map_tiles", "map_memory", "scratch_dir"},
          RunMap};
}

}  // namespace planegraph::tools
