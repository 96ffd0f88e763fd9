#include <sys/resource.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <numbers>

#include "pipeline/observability_json.h"
#include "pipeline/reference.h"
#include "pipeline/switched_off_json.h"
#include "planegraph/base/error.h"
#include "planegraph/evaluation/trajectory_error.h"
#include "planegraph/pipeline/outputs.h"

namespace planegraph {
namespace {

using Json = nlohmann::json;

Json Number(double value) { return std::isfinite(value) ? Json(value) : Json(nullptr); }

template <typename Vector>
Json Array(const Vector& v) {
  Json array = Json::array();
  for (int i = 0; i < v.size(); ++i) array.push_back(Number(v[i]));
  return array;
}

Json PoseJson(const Rigid3& pose) {
  return {{"translation", Array(pose.translation)}, {"rotation", Array(pose.rotation.coeffs())}};
}

Json MatrixJson(const Matrix6d& matrix) {
  Json rows = Json::array();
  for (int r = 0; r < 6; ++r) rows.push_back(Array(Eigen::VectorXd(matrix.row(r).transpose())));
  return rows;
}

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

Json SimilarityJson(const Sim3& similarity) {
  Json json = PoseJson({similarity.rotation, similarity.translation});
  json["scale"] = similarity.scale;
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

Json GeoreferenceJson(const Georeference& g) {
  return {{"status", g.status},
          {"reason", g.reason},
          {"scale", Number(g.world_from_map.scale)},
          {"sigma_scale", Number(g.sigma_scale)},
          {"rms", Number(g.rms)},
          {"inliers", g.inliers.size()},
          {"fixes", g.fixes.size()}};
}

// Where the pictures were taken, in the world.
Json CamerasJson(const MapRecord& map, const Sim3& world_from_map) {
  Json list = Json::array();
  if (!map.georeference) return list;
  for (const CameraFix& fix : map.georeference->fixes) {
    list.push_back(Array(Eigen::Vector3d(world_from_map * fix.centre_in_map)));
  }
  return list;
}

// What the laser has seen of each tile: surfaces.
std::vector<int> SeenByTile(const MapResult& result, std::size_t m) {
  const Graph& graph = result.solution.graph;
  std::vector<int> seen(graph.maps.size(), 0);
  for (const PlaneLandmark& plane : graph.planes) {
    for (const PlaneObservation& one : plane.observations) {
      if (one.map >= 0) ++seen[one.map];
    }
  }
  std::vector<int> of_map;
  for (std::size_t n = 0; n < seen.size(); ++n) {
    if (graph.maps[n].user_tag == static_cast<int>(m)) of_map.push_back(seen[n]);
  }
  return of_map;
}

// The tiles of a bent map, and how far they are off the similarity that stands for the whole.
Json TilesJson(const MapResult& result, std::size_t m) {
  const BentMap& bent = result.solution.bent_maps[m];
  const MapRecord& map = result.maps[m];
  const BendingFit fit = FitBentMap(bent, map.planes);
  const MapTiling& tiling = bent.grid->tiling();
  const std::vector<int> seen = SeenByTile(result, m);
  Json nodes = Json::array();
  for (std::size_t t = 0; t < bent.world_from_tile.size(); ++t) {
    const Eigen::Vector3d& middle = bent.grid->Middle(static_cast<int>(t));
    const Eigen::Vector3d at = bent.world_from_tile[t] * middle;
    const bool known = t < result.tile_sigmas[m].size();
    nodes.push_back(
        {{"middle", Array(at)},
         {"world_from_map", SimilarityJson(bent.world_from_tile[t] * map.metric_from_map)},
         {"bent", Array(Eigen::Vector3d(at - fit.world_from_metric * middle))},
         {"sigma", known ? Number(result.tile_sigmas[m][t]) : Json(nullptr)},
         {"surfaces", t < seen.size() ? seen[t] : 0}});
  }
  return {{"size", tiling.size},
          {"sigma_scale", tiling.sigma_scale},
          {"sigma_rotation_deg", tiling.sigma_rotation * 180.0 / std::numbers::pi},
          {"sigma_translation", tiling.sigma_translation},
          {"rms", fit.rms},
          {"largest", fit.largest},
          {"nodes", nodes}};
}

Json MapJson(const MapResult& result, std::size_t m) {
  const MapRecord& map = result.maps[m];
  Json json = {{"id", map.id},
               {"points", map.points},
               {"planes", map.planes.planes.size()},
               {"patches", map.planes.patches.size()},
               {"noise", {{"constant", map.planes.noise.constant}}},
               {"world_from_map",
                SimilarityJson(result.solution.world_from_metric[m] * map.metric_from_map)},
               {"sigma_scale", nullptr},
               {"covariance", nullptr},
               {"georeference", nullptr},
               {"seconds", {{"read", map.seconds_read}, {"segment", map.seconds_segment}}}};
  if (map.georeference) json["georeference"] = GeoreferenceJson(*map.georeference);
  json["cameras"] = CamerasJson(map, result.solution.world_from_metric[m] * map.metric_from_map);
  if (m < result.solution.bent_maps.size() && result.solution.bent_maps[m].grid) {
    json["tiles"] = TilesJson(result, m);
  }
  // Without a scan in it the joint solve says nothing of a map.
  const bool joined = std::any_of(result.map_pairs.begin(), result.map_pairs.end(),
                                  [m](const auto& pair) { return pair.used && pair.map == m; });
  if (joined && m < result.map_covariances.size()) {
    json["sigma_scale"] = Number(std::sqrt(result.map_covariances[m](6, 6)));
    json["covariance"] = Json::array();
    for (int r = 0; r < 7; ++r) {
      json["covariance"].push_back(
          Array(Eigen::VectorXd(result.map_covariances[m].row(r).transpose())));
    }
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

Json FiltersJson(const RobotSite& robot) {
  Json list = Json::array();
  for (const FilterStep& step : robot.filters) list.push_back({{step.name, step.parameters}});
  return list;
}

Json NoiseJson(const OdometryNoise& noise) {
  constexpr double kDegree = std::numbers::pi / 180.0;
  return {{"step", noise.step},         {"per_metre", noise.per_metre},
          {"scale", noise.scale},       {"step_deg", noise.step_rotation / kDegree},
          {"per_turn", noise.per_turn}, {"per_metre_deg", noise.rotation_per_metre / kDegree}};
}

// What was in effect, defaults included.
Json ConfigurationJson(const MapResult& result, const MapOptions& options) {
  const SegmentationOptions& segmentation = options.segmentation;
  Json json = {{"optimizer", options.optimizer},
               {"plane_factor", options.plane_factor},
               {"loss", LossText(options)},
               {"covariance", Name(options.covariance)},
               {"neighbours_per_scan", options.neighbours_per_scan},
               {"most_rounds", options.most_rounds},
               {"segmentation",
                {{"cell_size", segmentation.cell_size},
                 {"min_points", segmentation.min_points},
                 {"min_area", segmentation.min_area}}}};
  for (const RobotSite& robot : result.site.robots) {
    json["robots"][robot.name] = {{"scans", robot.scans.size()},
                                  {"format", robot.format},
                                  {"odometry", robot.odometry.has_value()},
                                  {"odometry_noise", NoiseJson(robot.odometry_noise)},
                                  {"start", robot.start.has_value()},
                                  {"reference", !robot.reference.empty()},
                                  {"filters", FiltersJson(robot)}};
  }
  return json;
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
