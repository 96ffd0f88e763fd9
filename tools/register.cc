// `planegraph register`: the pose between two clouds by their planes.
#include <gflags/gflags.h>

#include <Eigen/Eigenvalues>
#include <cmath>
#include <cstdio>
#include <iostream>
#include <numbers>

#include "planegraph/base/error.h"
#include "planegraph/geometry/rotation.h"
#include "planegraph/geometry/sim3.h"
#include "planegraph/registration/map_registration.h"
#include "planegraph/registration/registration.h"
#include "planegraph/registration/xiao.h"
#include "tools/command.h"
#include "tools/common_flags.h"
#include "tools/plane_input.h"
#include "tools/pose_json.h"

DEFINE_string(source_kind, "laser", "where the source comes from: laser or vision");
DEFINE_string(target_kind, "laser", "where the target comes from: laser or vision");
DEFINE_string(guess, "", "a first target_from_source: tx,ty,tz,qx,qy,qz,qw");
DEFINE_string(guess_sigma, "0.5,5deg",
              "standard deviation of the guess: METRES,RADIANS or METRES,DEGREESdeg, each axis");
DEFINE_string(map_scale, "", "metres per unit of the target, S or S:SIGMA");
DEFINE_string(matcher, "ours", "how planes are matched: ours or xiao");

namespace planegraph::tools {
namespace {

// Larger standard deviations stand for "nothing is known", metres or radians.
constexpr double kUnheld = 100.0;

Rigid3 ParsePose(const std::string& text) {
  const std::vector<double> n = ParseNumbers("guess", text);
  if (n.size() != 7) throw UsageError("--guess takes tx,ty,tz,qx,qy,qz,qw");
  const Eigen::Quaterniond rotation(n[6], n[3], n[4], n[5]);
  if (!(std::abs(rotation.norm() - 1.0) < 0.01)) {
    throw UsageError("--guess: the quaternion is not of unit length");
  }
  return {rotation.normalized(), {n[0], n[1], n[2]}};
}

Matrix6d ParseSigmas(std::string text) {
  const bool degrees = text.ends_with("deg");
  if (degrees) text.resize(text.size() - 3);
  std::vector<double> n = ParseNumbers("guess_sigma", text);
  if (n.size() != 2 || !(n[0] > 0.0 && n[1] > 0.0)) {
    throw UsageError("--guess_sigma takes METRES,RADIANS or METRES,DEGREESdeg");
  }
  if (degrees) n[1] *= std::numbers::pi / 180.0;
  Matrix6d covariance = Matrix6d::Identity();
  covariance.diagonal().head<3>().setConstant(n[0] * n[0]);
  covariance.diagonal().tail<3>().setConstant(n[1] * n[1]);
  return covariance;
}

// The planes leave their clouds' offsets out; these two take a pose from one convention to the
// other.
Rigid3 WithoutOffsets(const Rigid3& pose, const PlaneSet& target, const PlaneSet& source) {
  return {pose.rotation, pose.translation - target.offset + pose.rotation * source.offset};
}
Rigid3 WithOffsets(const Rigid3& pose, const PlaneSet& target, const PlaneSet& source) {
  return {pose.rotation, pose.translation + target.offset - pose.rotation * source.offset};
}

// The source's offset is a lever between rotation and translation.
Matrix6d CovarianceWithOffsets(const Refinement& result, const PlaneSet& source) {
  Matrix6d jacobian = Matrix6d::Identity();
  jacobian.topRightCorner<3, 3>() = Hat(result.target_from_source.rotation * source.offset);
  return jacobian * result.covariance * jacobian.transpose();
}

nlohmann::json UnobservedToJson(const std::vector<UnobservedDirection>& unobserved) {
  nlohmann::json out = nlohmann::json::array();
  for (const auto& open : unobserved) {
    const auto& d = open.direction;
    out.push_back(
        {{"direction", {d[0], d[1], d[2], d[3], d[4], d[5]}},
         {"sigma", FiniteOrNull(open.sigma, kUnheld)},
         {"held_by", open.held_by.empty() ? nlohmann::json() : nlohmann::json(open.held_by)}});
  }
  return out;
}

nlohmann::json PairsToJson(const std::vector<PlanePair>& pairs, const PlaneSet& target,
                           const PlaneSet& source) {
  nlohmann::json out = nlohmann::json::array();
  for (const PlanePair& pair : pairs) {
    out.push_back(
        {{"source", source.planes[pair.source].id}, {"target", target.planes[pair.target].id}});
  }
  return out;
}

// Whether anything was matched at all.
bool HasPose(const Refinement& result) {
  return result.pairs > 0 || !result.correspondences.empty();
}

nlohmann::json ToJson(const Registration& result, const PlaneSet& target, const PlaneSet& source,
                      double scale) {
  Rigid3 pose = WithOffsets(result.target_from_source(), target, source);
  pose.translation /= scale;
  nlohmann::json json = {
      {"target_from_source", PoseToJson(pose)},
      {"status", ToString(result.status)},
      {"reason", result.reason},
      {"correspondences", PairsToJson(result.refinement.correspondences, target, source)},
      {"covariance",
       CovarianceToJson(CovarianceWithOffsets(result.refinement, source), kUnheld * kUnheld)},
      {"unobserved", UnobservedToJson(result.unobserved)},
      {"quality", result.quality},
      {"runner_up", result.runner_up},
      {"rms", result.refinement.rms},
      {"planes", {{"source", source.planes.size()}, {"target", target.planes.size()}}}};
  if (result.quality_back) json["quality_back"] = *result.quality_back;
  if (!HasPose(result.refinement)) json["covariance"] = json["target_from_source"] = nullptr;
  if (!FLAGS_map_scale.empty() && HasPose(result.refinement))
    json["target_from_source"]["scale"] = 1.0 / scale;
  return json;
}

Registration RunMatcher(const ScanModel& target, const ScanModel& source) {
  if (FLAGS_matcher == "xiao") return RegisterXiao(*target.planes, *source.planes);
  if (FLAGS_guess.empty()) return Register(target, source);
  const Rigid3 guess = WithoutOffsets(ParsePose(FLAGS_guess), *target.planes, *source.planes);
  return RegisterFromGuess(target, source, {guess, ParseSigmas(FLAGS_guess_sigma)});
}

void PrintSummary(const nlohmann::json& json, const Registration& result) {
  std::printf("%s%s%s\n", ToString(result.status), result.reason.empty() ? "" : ": ",
              result.reason.c_str());
  if (!HasPose(result.refinement)) return;
  const Eigen::Vector3d angles =
      LogSO3(result.target_from_source().rotation) * 180.0 / std::numbers::pi;
  const Matrix6d& covariance = result.refinement.covariance;
  const auto sigma = [&](int first) {
    return std::sqrt(covariance.diagonal().segment<3>(first).maxCoeff());
  };
  std::printf("translation %s m, rotation vector (%.3f, %.3f, %.3f) deg\n",
              json["target_from_source"]["translation"].dump().c_str(), angles.x(), angles.y(),
              angles.z());
  std::printf("largest sigma %.3f m, %.3f deg; %zu pairs of planes; %.2f s\n", sigma(0),
              sigma(3) * 180.0 / std::numbers::pi, result.refinement.correspondences.size(),
              SecondsSinceStart());
}

void CheckRegisterFlags() {
  if (FLAGS_matcher != "ours" && FLAGS_matcher != "xiao") {
    throw UsageError("--matcher must be ours or xiao, not '" + FLAGS_matcher + "'");
  }
  if (FLAGS_matcher == "xiao" && !FLAGS_guess.empty()) {
    throw UsageError("--matcher=xiao takes no --guess");
  }
  if (!FLAGS_guess.empty()) ParsePose(FLAGS_guess), ParseSigmas(FLAGS_guess_sigma);
}

// A drone map as the target: its scale is an unknown with a prior, and its surfaces do not see free
// space themselves.
MapLocationOptions LocationOptionsFromFlags(const ScaleOfMap& scale, const PlaneSet& source) {
  MapLocationOptions options;
  options.threads = FLAGS_threads;
  options.prior.sigma_scale = scale.sigma;
  if (FLAGS_guess.empty()) return options;
  const Matrix6d sigmas = ParseSigmas(FLAGS_guess_sigma);
  Rigid3 guess = ParsePose(FLAGS_guess);
  guess.translation = scale.scale * guess.translation + guess.rotation * source.offset;
  options.prior.pose = MapPrior::Pose{guess, std::sqrt(sigmas(0, 0)), std::sqrt(sigmas(5, 5))};
  return options;
}

std::vector<UnobservedDirection> OpenInMap(const Matrix6d& covariance) {
  constexpr double kWeakTranslation = 0.1, kWeakRotation = 0.0175;
  std::vector<UnobservedDirection> open;
  for (const int first : {0, 3}) {
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> eigen(
        Eigen::Matrix3d(covariance.block<3, 3>(first, first)));
    for (int k = 2; k >= 0; --k) {
      const double sigma = std::sqrt(std::max(eigen.eigenvalues()[k], 0.0));
      if (sigma <= (first == 0 ? kWeakTranslation : kWeakRotation)) break;
      UnobservedDirection& direction = open.emplace_back();
      direction.direction.segment<3>(first) = eigen.eigenvectors().col(k);
      direction.sigma = sigma;
    }
  }
  return open;
}

nlohmann::json MapResultToJson(const MapLocation& location, const MapModel& map,
                               const ScanModel& source, const ScaleOfMap& scale) {
  nlohmann::json json = {
      {"target_from_source", nullptr}, {"status", ToString(location.status)},
      {"reason", location.reason},     {"correspondences", nlohmann::json::array()},
      {"covariance", nullptr},         {"unobserved", nlohmann::json::array()},
      {"quality", location.r1},        {"runner_up", location.r2}};
  if (location.candidates.empty()) return json;
  const MapRefinement& found = location.candidates.front().refinement;
  const Sim3& metric = found.map_from_group;
  // The offset of the target's cloud is part of its own frame, that of the source of the source's.
  const Sim3 target_from_metric(1.0 / scale.scale, Eigen::Quaterniond::Identity(),
                                map.planes().offset / scale.scale);
  const Sim3 shift(1.0, Eigen::Quaterniond::Identity(), -source.planes->offset);
  const Sim3 pose = target_from_metric * metric * shift;
  json["target_from_source"] = SimilarityToJson(pose);
  const Matrix6d covariance = found.covariance.topLeftCorner<6, 6>();
  json["covariance"] = CovarianceToJson(covariance, kUnheld * kUnheld);
  json["sigma_scale"] = std::sqrt(found.covariance(6, 6));
  json["unobserved"] = UnobservedToJson(OpenInMap(covariance));
  json["correspondences"] =
      PairsToJson(MapCorrespondences(map, source, metric, 0.15), map.planes(), *source.planes);
  return json;
}

int RegisterInMap(const PlaneSet& target, const PlaneSet& source, const ScaleOfMap& scale) {
  const MapModel map(target);
  const ScanModel scan(source);
  const MapLocation location =
      LocateInMap(map, ScanGroup(scan), LocationOptionsFromFlags(scale, source));
  const nlohmann::json json = MapResultToJson(location, map, scan, scale);
  if (WantsText()) {
    std::printf("%s%s%s\ntarget_from_source %s\n", ToString(location.status),
                location.reason.empty() ? "" : ": ", location.reason.c_str(),
                json["target_from_source"].dump().c_str());
  }
  EmitResult(json, true);
  if (location.status == RegistrationStatus::kOk) return 0;
  throw NoResultError(std::string(ToString(location.status)) + ": " + location.reason);
}

int RunRegister(const std::vector<std::string>& arguments) {
  ExpectArguments(arguments, 2, 2);
  CheckRegisterFlags();
  const ScaleOfMap map_scale = ParseMapScale(FLAGS_map_scale);
  const double scale = map_scale.scale;
  if (scale != 1.0 && IsPlanesFile(arguments[1])) {
    throw UsageError("--map_scale needs the target's cloud: planes in a file are metric");
  }
  const PlaneSet source =
      LoadPlanes(arguments[0], ParseKind("source_kind", FLAGS_source_kind), 1.0);
  const PlaneSet target =
      LoadPlanes(arguments[1], ParseKind("target_kind", FLAGS_target_kind), scale);
  if (target.kind == CloudKind::kVision && FLAGS_matcher == "ours") {
    return RegisterInMap(target, source, map_scale);
  }
  const Registration result = RunMatcher(ScanModel(target), ScanModel(source));
  const nlohmann::json json = ToJson(result, target, source, scale);
  if (WantsText()) PrintSummary(json, result);
  EmitResult(json, true);
  if (result.status == RegistrationStatus::kOk) return 0;
  throw NoResultError(std::string(ToString(result.status)) + ": " + result.reason);
}

}  // namespace

Command RegisterCommand() {
  std::vector<std::string> flags = {"output",      "source_kind", "target_kind", "guess",
                                    "guess_sigma", "map_scale",   "matcher"};
  for (const auto& flag : SegmentationFlags()) flags.push_back(flag);
  return {"register", "SOURCE TARGET",
          "the pose between two clouds (or PLANES.json), no guess needed", flags, RunRegister};
}

}  // namespace planegraph::tools
