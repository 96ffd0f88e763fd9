// `planegraph locate`: where one scan, or several as a group, stand in a drone map.
#include <gflags/gflags.h>

#include <cmath>
#include <cstdio>
#include <iostream>
#include <memory>

#include "planegraph/base/error.h"
#include "planegraph/base/parallel.h"
#include "planegraph/io/trajectory_io.h"
#include "planegraph/pipeline/map_front_end.h"
#include "planegraph/registration/cell_search.h"
#include "planegraph/registration/map_registration.h"
#include "tools/command.h"
#include "tools/common_flags.h"
#include "tools/map_memory.h"
#include "tools/plane_input.h"
#include "tools/pose_json.h"

DECLARE_string(map);
DEFINE_string(odometry, "", "TUM file that ties several scans to a group, a line for each");
DECLARE_string(map_scale);

namespace planegraph::tools {
namespace {

void CheckLocateFlags(const std::string& method) {
  RequireFlag("map");
  if (method != "vote" && method != "cells") {
    throw UsageError("--method must be vote or cells, not '" + method + "'");
  }
  if (!FLAGS_map_scale.empty() && !FLAGS_gps.empty()) {
    throw UsageError("the map's scale comes from --map_scale or from --gps, not from both");
  }
  if (FLAGS_gps.empty() != FLAGS_cameras.empty()) {
    throw UsageError("--gps and --cameras go together");
  }
}

MapRecord ReadMap() {
  Site site;
  DroneMapSite map{FLAGS_map, FLAGS_map, FLAGS_cameras, FLAGS_gps, FLAGS_image_times, {}, {}};
  const ScaleOfMap scale = ParseMapScale(FLAGS_map_scale);
  if (FLAGS_gps.empty() && !FLAGS_map_scale.empty()) {
    map.scale = scale.scale;
    map.scale_sigma = scale.sigma;
  }
  site.maps.push_back(map);
  std::vector<std::string> warnings;
  MapRecord record = PrepareMap(site, 0, FLAGS_threads, &warnings, MapMemoryFromFlags(""));
  if (!FLAGS_gps.empty() && !record.has_position()) throw NoResultError(warnings.front());
  for (const std::string& warning : warnings) std::cerr << "warning: " << warning << "\n";
  return record;
}

struct Scans {
  std::vector<std::unique_ptr<PlaneSet>> planes;
  std::vector<std::unique_ptr<ScanModel>> models;
  ScanGroup group;
};

Rigid3 Step(const Scans& scans, std::size_t k, const std::string& file) {
  const Registration r = Register(*scans.models[k - 1], *scans.models[k]);
  if (r.status != RegistrationStatus::kOk) {
    throw NoResultError(file + ": cannot be tied to the scan before it without --odometry: " +
                        ToString(r.status) + ": " + r.reason);
  }
  return r.target_from_source();
}

// One pose for each scan, relative to the first: by odometry, improved by registration where that
// succeeds; without odometry by registration alone.
void TieScans(const std::vector<std::string>& files, Scans* scans) {
  std::optional<Trajectory> odometry;
  if (!FLAGS_odometry.empty()) odometry = ReadTrajectory(FLAGS_odometry);
  if (odometry && odometry->size() != files.size()) {
    throw InputError::InFile(FLAGS_odometry, "has " + std::to_string(odometry->size()) +
                                                 " poses for " + std::to_string(files.size()) +
                                                 " scans");
  }
  Rigid3 pose;
  for (std::size_t k = 0; k < files.size(); ++k) {
    if (k > 0 && odometry) {
      const Rigid3 guess = odometry->poses[k - 1].Inverse() * odometry->poses[k];
      const PosePrior weak{guess, 1e4 * Matrix6d::Identity()};
      const Registration r = RegisterFromGuess(*scans->models[k - 1], *scans->models[k], weak);
      pose = pose * (r.status == RegistrationStatus::kOk ? r.target_from_source() : guess);
    } else if (k > 0) {
      pose = pose * Step(*scans, k, files[k]);
    }
    scans->group.scans.push_back(scans->models[k].get());
    scans->group.group_from_scan.push_back(pose);
  }
}

Scans ReadScans(const std::vector<std::string>& files) {
  Scans scans;
  scans.planes.resize(files.size());
  ParallelFor(files.size(), FLAGS_threads, [&](std::size_t k) {
    scans.planes[k] = std::make_unique<PlaneSet>(LoadPlanes(files[k], CloudKind::kLaser, 1.0));
  });
  for (const auto& planes : scans.planes) {
    scans.models.push_back(std::make_unique<ScanModel>(*planes));
  }
  TieScans(files, &scans);
  return scans;
}

MapLocation Locate(const MapRecord& map, const Scans& scans, const std::string& method) {
  if (method == "cells") {
    if (scans.planes.size() != 1)
      throw UsageError("--method=cells takes one scan, as the paper does");
    CellSearchOptions options;
    options.threads = FLAGS_threads;
    return LocateByCells(map.planes, *scans.planes[0], options);
  }
  MapLocationOptions options;
  options.threads = FLAGS_threads;
  options.prior.sigma_scale = map.sigma_scale;
  options.prior.upright = map.has_position();
  return LocateInMap(MapModel(map.planes), scans.group, options);
}

// Null where nothing was compared, as by the search over cells.
nlohmann::json ToJson(const MapSlide& slid) {
  if (!(slid.metres > 0.0)) return nullptr;
  const Eigen::Vector3d& d = slid.direction;
  return {{"direction", {d.x(), d.y(), d.z()}},
          {"metres", slid.metres},
          {"probability", slid.probability}};
}

nlohmann::json ToJson(const MapLocation& location, const MapRecord& map) {
  nlohmann::json candidates = nlohmann::json::array();
  for (const MapCandidate& candidate : location.candidates) {
    const Sim3 pose = map.metric_from_map.Inverse() * candidate.refinement.map_from_group;
    candidates.push_back(
        {{"map_from_scan", SimilarityToJson(pose)},
         {"score", FLAGS_method == "cells" ? candidate.evidence.agree : candidate.probability},
         {"agree", candidate.evidence.agree},
         {"log_likelihood", candidate.log_likelihood},
         {"confirmed", candidate.evidence.confirmed},
         {"contradicted", candidate.evidence.contradicted},
         {"worst_direction", candidate.evidence.worst_direction},
         {"pierced", candidate.evidence.pierced}});
  }
  return {{"status", ToString(location.status)},
          {"reason", location.reason},
          {"candidates", candidates},
          {"r1", location.r1},
          {"r2", location.r2},
          {"chance", location.chance},
          {"nowhere", location.nowhere},
          {"slid", ToJson(location.slid)},
          {"map", {{"planes", map.planes.planes.size()}, {"sigma_scale", map.sigma_scale}}}};
}

int RunLocate(const std::vector<std::string>& arguments) {
  ExpectArguments(arguments, 1, 1000);
  if (FLAGS_method.empty()) FLAGS_method = "vote";
  CheckLocateFlags(FLAGS_method);
  const MapRecord map = ReadMap();
  const Scans scans = ReadScans(arguments);
  const MapLocation location = Locate(map, scans, FLAGS_method);
  const nlohmann::json json = ToJson(location, map);
  if (WantsText()) {
    std::printf("%s%s%s\n", ToString(location.status), location.reason.empty() ? "" : ": ",
                location.reason.c_str());
    if (!json["candidates"].empty()) {
      std::printf("map_from_scan %s\n", json["candidates"][0]["map_from_scan"].dump().c_str());
    }
    std::printf("score %.3f, the next different place %.3f; %.2f s\n", location.r1, location.r2,
                SecondsSinceStart());
    if (location.slid.metres > 0.0) {
      std::printf("its closest rival beside it: %.2f m along %.2f %.2f %.2f, probability %.1e\n",
                  location.slid.metres, location.slid.direction.x(), location.slid.direction.y(),
                  location.slid.direction.z(), location.slid.probability);
    }
  }
  EmitResult(json, true);
  if (location.status == RegistrationStatus::kOk) return 0;
  throw NoResultError(std::string(ToString(location.status)) + ": " + location.reason);
}

}  // namespace

Command LocateCommand() {
  std::vector<std::string> flags = {"map",        "odometry",    "map_scale", "cameras",
                                    "gps",        "image_times", "method",    "output",
                                    "map_memory", "scratch_dir"};
  for (const auto& flag : SegmentationFlags()) flags.push_back(flag);
  return {"locate", "SCAN...", "where one scan, or several as a group, stand in a drone map", flags,
          RunLocate};
}

}  // namespace planegraph::tools
