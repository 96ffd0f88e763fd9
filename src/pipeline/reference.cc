#include "pipeline/reference.h"

#include <algorithm>
#include <cmath>
#include <map>

#include "planegraph/base/error.h"
#include "planegraph/evaluation/consistency.h"
#include "planegraph/geometry/rotation.h"
#include "planegraph/graph/pose_error.h"
#include "planegraph/solve/covariance.h"

namespace planegraph {
namespace {

using Json = nlohmann::json;

// Up to so many poses their joint covariance is affordable: a square matrix of six times that.
constexpr std::size_t kMostJoint = 200;

Trajectory EstimateOf(const MapResult& result, std::size_t robot, bool has_times) {
  Trajectory trajectory;
  trajectory.has_times = has_times;
  for (const std::size_t i : ScansInFileOrder(result, robot)) {
    trajectory.times.push_back(result.scans[i].time);
    trajectory.poses.push_back(result.solution.world_from_scan[i]);
  }
  return trajectory;
}

// A robot's scans with their true poses, those of one component alone: that with the most of them.
struct TruePoses {
  std::vector<int> scans;
  std::vector<Rigid3> truth;
};

Rigid3 NearestRigid(const MatrixPose& pose) {
  return {Eigen::Quaterniond(ProjectToRotation(pose.rotation)).normalized(), pose.translation};
}

// None where the reference does not fit: the evaluation says why.
PosePairs PairsOrNone(const MapResult& result, std::size_t robot) {
  try {
    return PairWithReference(result, robot);
  } catch (const NoResultError&) {
    return {};
  } catch (const InputError&) {
    return {};
  }
}

TruePoses LargestComponent(const MapResult& result, std::size_t robot) {
  const PosePairs pairs = PairsOrNone(result, robot);
  const std::vector<std::size_t> order = ScansInFileOrder(result, robot);
  std::map<int, TruePoses> components;
  for (std::size_t k = 0; k < pairs.reference.size(); ++k) {
    const std::size_t scan = order[pairs.estimate_indices[k]];
    TruePoses& component = components[result.component[scan]];
    component.scans.push_back(static_cast<int>(scan));
    component.truth.push_back(NearestRigid(pairs.reference[k]));
  }
  TruePoses largest;
  for (auto& [number, component] : components) {
    if (component.scans.size() > largest.scans.size()) largest = std::move(component);
  }
  return largest;
}

// Of the poses relative to the first of them, in its axes.
std::optional<Consistency> OfRobot(const MapResult& result, const TruePoses& poses) {
  if (poses.scans.size() < 2) return std::nullopt;
  const int first = poses.scans.front();
  const std::vector<int> others(poses.scans.begin() + 1, poses.scans.end());
  const auto& estimate = result.solution.world_from_scan;
  std::vector<Eigen::VectorXd> errors;
  std::vector<Eigen::MatrixXd> covariances;
  Eigen::MatrixXd joint;
  if (others.size() <= kMostJoint) joint = result.covariance->Relatives(first, others);
  for (std::size_t k = 0; k < others.size(); ++k) {
    const Rigid3 truth = poses.truth[0].Inverse() * poses.truth[k + 1];
    errors.push_back(PoseError(estimate[first].Inverse() * estimate[others[k]], truth));
    const auto at = static_cast<Eigen::Index>(6 * k);
    covariances.push_back(joint.size() > 0
                              ? Eigen::MatrixXd(joint.block<6, 6>(at, at))
                              : Eigen::MatrixXd(result.covariance->Relative(first, others[k])));
  }
  return MeasureConsistency(errors, covariances, joint);
}

Json CoverageJson(const std::array<double, 3>& coverage) {
  Json json;
  for (std::size_t k = 0; k < coverage.size(); ++k) {
    json[std::to_string(std::lround(100.0 * kCoverageLevels[k]))] = coverage[k];
  }
  return json;
}

Json SummaryJson(const Consistency& consistency, const char* nees) {
  Json json = {{nees, consistency.Nees()},
               {"degrees_of_freedom", consistency.all.degrees},
               {"joint", consistency.joint},
               {"band", consistency.band ? Json(*consistency.band) : Json(nullptr)},
               {"count", consistency.each.size()},
               {"coverage", CoverageJson(consistency.coverage)}};
  for (const NormalizedError& one : consistency.each) {
    json["each"].push_back(one.squared / one.degrees);
  }
  return json;
}

// All robots or maps together; jointly only where there is one.
Json TogetherJson(const std::vector<Consistency>& parts, const char* nees) {
  Consistency all = parts.front();
  for (std::size_t k = 1; k < parts.size(); ++k) {
    all.each.insert(all.each.end(), parts[k].each.begin(), parts[k].each.end());
    all.all.squared += parts[k].all.squared;
    all.all.degrees += parts[k].all.degrees;
    all.joint = false;
    all.band.reset();
  }
  all.coverage = Coverage(all.each);
  Json json = SummaryJson(all, nees);
  json.erase("each");
  return json;
}

Json PosesJson(const MapResult& result) {
  Json robots = Json::object();
  std::vector<Consistency> parts;
  for (std::size_t r = 0; r < result.site.robots.size(); ++r) {
    if (result.site.robots[r].reference.empty()) continue;
    const TruePoses poses = LargestComponent(result, r);
    const auto consistency = OfRobot(result, poses);
    if (!consistency) continue;
    parts.push_back(*consistency);
    Json& json = robots[result.site.robots[r].name];
    json = SummaryJson(*consistency, "nees");
    json["relative_to"] = result.scans[poses.scans.front()].id;
  }
  if (parts.empty()) return Json::object();
  Json json = TogetherJson(parts, "pose_nees");
  json["robots"] = robots;
  return json;
}

// A map that holds no scan has no covariance of its own.
bool HasScan(const MapResult& result, std::size_t map) {
  return std::any_of(result.map_pairs.begin(), result.map_pairs.end(),
                     [map](const auto& pair) { return pair.used && pair.map == map; });
}

std::optional<Consistency> OfScale(const MapResult& result, std::size_t m) {
  const std::optional<double>& truth = result.site.maps[m].true_scale;
  if (!truth || !HasScan(result, m)) return std::nullopt;
  const Sim3 found = result.solution.world_from_metric[m] * result.maps[m].metric_from_map;
  const Eigen::VectorXd error = Eigen::VectorXd::Constant(1, std::log(found.scale / *truth));
  const Eigen::MatrixXd variance = Eigen::MatrixXd::Constant(1, 1, result.map_covariances[m](6, 6));
  return MeasureConsistency({error}, {variance}, {});
}

void AddScales(const MapResult& result, Json* json) {
  std::vector<Consistency> parts;
  for (std::size_t m = 0; m < result.map_covariances.size(); ++m) {
    const auto consistency = OfScale(result, m);
    if (!consistency) continue;
    parts.push_back(*consistency);
    (*json)["maps"][result.maps[m].id] = {{"true_scale", *result.site.maps[m].true_scale},
                                          {"nees", consistency->Nees()}};
  }
  if (parts.empty()) return;
  const Json together = TogetherJson(parts, "scale_nees");
  (*json)["scale_nees"] = together["scale_nees"];
  (*json)["scale_coverage"] = together["coverage"];
}

}  // namespace

PosePairs PairWithReference(const MapResult& result, std::size_t robot) {
  const RobotSite& site = result.site.robots[robot];
  const Trajectory reference = ReadTrajectory(site.reference);
  const bool by_time = site.odometry && site.odometry->has_times && reference.has_times;
  return PairPoses(reference, EstimateOf(result, robot, by_time));
}

Json ReferenceJson(const MapResult& result) {
  if (!result.covariance) return {{"consistency", Json::object()}};
  Json consistency = PosesJson(result);
  AddScales(result, &consistency);
  return {{"consistency", consistency}};
}

}  // namespace planegraph
