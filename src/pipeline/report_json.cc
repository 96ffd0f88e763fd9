#include <sys/resource.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "pipeline/configuration_json.h"
#include "pipeline/json_values.h"
#include "pipeline/map_json.h"
#include "pipeline/observability_json.h"
#include "pipeline/reference.h"
#include "pipeline/switched_off_json.h"
#include "planegraph/base/error.h"
#include "planegraph/evaluation/trajectory_error.h"
#include "planegraph/pipeline/outputs.h"

namespace planegraph {
namespace {

using Json = nlohmann::json;

Json UnobservedJson(const std::vector<UnobservedDirection>& unobserved) {
  Json list = Json::array();
  for (const auto& open : unobserved) {
    list.push_back({{"direction", Array(open.direction)},
                    {"sigma", Number(open.sigma)},
                    {"held_by", open.held_by.empty() ? Json(nullptr) : Json(open.held_by)}});
  }
  return list;
}

// Of a registration's measurements (heights of pairs of surfels) less its unknowns.
int Redundancy(std::size_t pairs) { return std::max(0, static_cast<int>(pairs) - 6); }

Json AnchoredTo(const MapResult& result, std::size_t scan) {
  Json names = Json::array();
  for (const auto& pair : result.map_pairs) {
    if (pair.used && pair.scan == scan) names.push_back(result.maps[pair.map].id);
  }
  return names;
}

Json ScanJson(const MapResult& result, std::size_t i) {
  const ScanRecord& scan = result.scans[i];
  Json json = {
      {"id", scan.id},
      {"points", scan.points},
      {"points_filtered", scan.points_filtered},
      {"planes", scan.planes.planes.size()},
      {"patches", scan.planes.patches.size()},
      {"noise",
       {{"constant", scan.planes.noise.constant}, {"per_metre", scan.planes.noise.per_metre}}},
      {"seconds",
       {{"read", scan.seconds_read},
        {"preprocess", scan.seconds_preprocess},
        {"segment", scan.seconds_segment}}},
      {"world_from_scan", PoseJson(result.solution.world_from_scan[i])},
      {"component", result.component[i]},
      {"covariance", nullptr},
      {"unobserved", Json::array()},
      {"anchored_to", AnchoredTo(result, i)}};
  if (i < result.covariances.size()) json["covariance"] = MatrixJson(result.covariances[i]);
  if (i < result.unobserved.size()) json["unobserved"] = UnobservedJson(result.unobserved[i]);
  return json;
}

Json MapPairJson(const MapResult& result, const MapPairRecord& pair) {
  const MapRecord& map = result.maps[pair.map];
  Json json = {{"target", map.id},
               {"source", result.scans[pair.scan].id},
               {"kind", "laser-map"},
               {"status", ToString(pair.status)},
               {"reason", pair.reason},
               {"correspondences", pair.correspondences},
               {"surfels", pair.refinement.residuals.size()},
               {"redundancy", Redundancy(pair.refinement.residuals.size())},
               {"rms", nullptr},
               {"tilt_rms", nullptr},
               {"floor", Number(pair.refinement.floor)},
               {"covariance", nullptr},
               {"quality", pair.evidence.agree},
               {"target_from_source",
                SimilarityJson(map.metric_from_map.Inverse() * pair.refinement.map_from_group)},
               {"unobserved", Json::array()},
               {"seconds", pair.seconds},
               {"used", pair.used}};
  if (!pair.refinement.residuals.empty()) {
    const MapErrors errors = MeasureMapErrors(pair.refinement.residuals);
    if (errors.measured) json["rms"] = errors.sigma;
    json["covariance"] = MatrixJson(pair.refinement.covariance.topLeftCorner<6, 6>());
  }
  return json;
}

Json OriginJson(const MapResult& result) {
  std::optional<GeodeticPosition> origin = result.site.origin;
  for (const MapRecord& map : result.maps) {
    if (!origin && map.has_position()) origin = map.georeference->origin;
  }
  if (!origin) return nullptr;
  return {{"lat", origin->latitude}, {"lon", origin->longitude}, {"alt", origin->altitude}};
}

Json PairJson(const MapResult& result, const PairRecord& pair) {
  const Registration& r = pair.registration;
  const bool found = r.refinement.pairs > 0;
  return {{"target", result.scans[pair.target].id},
          {"source", result.scans[pair.source].id},
          {"kind", "laser-laser"},
          {"status", ToString(r.status)},
          {"reason", r.reason},
          {"correspondences", r.refinement.correspondences.size()},
          {"surfels", r.refinement.pairs},
          {"redundancy", Redundancy(static_cast<std::size_t>(r.refinement.pairs))},
          {"rms", Number(r.refinement.rms)},
          {"tilt_rms", r.refinement.tilt_rms > 0 ? Json(r.refinement.tilt_rms) : Json(nullptr)},
          {"covariance", found ? MatrixJson(r.refinement.covariance) : Json(nullptr)},
          {"floor", Number(r.refinement.floor)},
          {"quality", r.quality},
          {"target_from_source", PoseJson(r.target_from_source())},
          {"unobserved", UnobservedJson(r.unobserved)},
          {"seconds", pair.seconds},
          {"used", pair.used}};
}

Json SolveJson(const MapResult& result, const MapOptions& options) {
  const JointSolution& s = result.solution;
  std::size_t observations = 0;
  for (const auto& plane : s.graph.planes) observations += plane.observations.size();
  return {{"optimizer", options.optimizer},
          {"plane_factor", options.plane_factor},
          {"loss", LossText(options)},
          {"initial_cost", s.summary.initial_cost},
          {"final_cost", s.summary.final_cost},
          {"iterations", s.summary.iterations},
          {"costs", s.costs},
          {"redundancy", s.summary.DegreesOfFreedom()},
          {"rounds", s.rounds},
          {"last_move", s.last_move},
          {"converged", s.summary.converged},
          {"landmarks", s.graph.planes.size()},
          {"observations", observations},
          {"floor_offset", s.floor_offset},
          {"floor_tilt", s.floor_tilt},
          {"seconds", s.seconds}};
}

Json StatisticsJson(const Statistics& s) {
  return {{"rmse", s.rmse}, {"mean", s.mean}, {"median", s.median},
          {"std", s.std},   {"min", s.min},   {"max", s.max}};
}

Json ErrorsJson(const PoseErrors& errors) {
  Json json = StatisticsJson(errors.translation);
  json["rotation"] = StatisticsJson(errors.rotation);
  json["count"] = errors.count;
  json["each"] = errors.translation_errors;
  json["rotation"]["each"] = errors.rotation_errors;
  return json;
}

// Alignment on the first pose where the positions do not define another one.
AteResult AteOrFirst(const PosePairs& pairs) {
  try {
    return ComputeAte(pairs, PoseAlignment::kSe3);
  } catch (const NoResultError&) {
    return ComputeAte(pairs, PoseAlignment::kFirst);
  }
}

Json EvaluationJson(const MapResult& result, std::size_t robot) {
  const PosePairs pairs = PairWithReference(result, robot);
  const AteResult ate = AteOrFirst(pairs);
  Json json = {{"ate", ErrorsJson(ate.errors)}};
  json["ate"]["alignment"] = Name(ate.alignment);
  if (pairs.estimate.size() < 2) return json;  // no step to measure
  const RpeResult rpe = ComputeRpe(pairs, {});
  json["rpe"] = ErrorsJson(rpe.errors);
  json["rpe"]["delta"] = 1;
  json["rpe"]["delta_unit"] = "frames";
  json["rpe"]["pairs"] = "consecutive";
  json["rpe"]["pairs_from"] = "reference";
  return json;
}

// A reference that does not fit must not cost the run its report.
void Evaluate(const MapResult& result, std::size_t robot, Json* report) {
  const std::string& name = result.site.robots[robot].name;
  if (result.site.robots[robot].reference.empty()) return;
  const auto warn = [&](const std::exception& error) {
    (*report)["warnings"].push_back("no evaluation of " + name + ": " + error.what());
  };
  try {
    (*report)["evaluation"][name] = EvaluationJson(result, robot);
  } catch (const NoResultError& error) {
    warn(error);
  } catch (const InputError& error) {
    warn(error);
  }
}

Json OdometryJson(const MapResult& result) {
  Json json = Json::object();
  for (std::size_t r = 0; r < result.odometry_scales.size(); ++r) {
    if (!result.site.robots[r].odometry) continue;
    Json& robot = json[result.site.robots[r].name];
    robot["scale"] = Number(result.odometry_scales[r]);
    robot["sigma_scale"] = result.odometry_scale_sigmas.empty()
                               ? Json(nullptr)
                               : Number(result.odometry_scale_sigmas[r]);
  }
  return json;
}

std::uint64_t PeakMemoryBytes() {
  rusage usage{};
  ::getrusage(RUSAGE_SELF, &usage);
  return static_cast<std::uint64_t>(usage.ru_maxrss) * 1024u;
}

}  // namespace

std::string ReportJson(const MapResult& result, const MapOptions& options) {
  Json report = {{"name", result.site.name},     {"origin", OriginJson(result)},
                 {"scans", Json::array()},       {"registrations", Json::array()},
                 {"maps", Json::array()},        {"solve", SolveJson(result, options)},
                 {"evaluation", Json::object()}, {"components", result.components},
                 {"warnings", result.warnings}};
  for (std::size_t i = 0; i < result.scans.size(); ++i) {
    report["scans"].push_back(ScanJson(result, i));
  }
  for (const auto& pair : result.pairs) report["registrations"].push_back(PairJson(result, pair));
  for (const auto& pair : result.map_pairs) {
    report["registrations"].push_back(MapPairJson(result, pair));
  }
  for (std::size_t m = 0; m < result.maps.size(); ++m) report["maps"].push_back(MapJson(result, m));
  for (std::size_t r = 0; r < result.site.robots.size(); ++r) Evaluate(result, r, &report);
  report["reference"] = ReferenceJson(result);
  report["observability"] = ObservabilityJson(result);
  report["stage_seconds"] = {
      {"front_end", result.seconds.front_end},  {"maps", result.seconds.maps},
      {"registration", result.seconds.pairing}, {"placing", result.seconds.placing},
      {"solve", result.seconds.solve},          {"covariance", result.seconds.covariance},
      {"output", result.seconds.output}};
  report["odometry"] = OdometryJson(result);
  report["switched_off"] = SwitchedOffJson(result);
  report["configuration"] = ConfigurationJson(result, options);
  report["peak_memory_bytes"] = PeakMemoryBytes();
  return report.dump(1);
}

}  // namespace planegraph
