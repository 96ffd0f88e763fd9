#include "planegraph/registration/xiao.h"

#include <algorithm>
#include <cmath>

#include "registration/competing_poses.h"

namespace planegraph {
namespace {

constexpr double kAmbiguousShare = 0.9;

std::size_t CountLarge(const PlaneSet& set, double min_area) {
  return static_cast<std::size_t>(
      std::count_if(set.planes.begin(), set.planes.end(),
                    [&](const PlaneSegment& plane) { return plane.area >= min_area; }));
}

std::vector<PlaneMatch> MakeMatches(const PlaneSet& target, const PlaneSet& source,
                                    const XiaoSolution& solution) {
  std::vector<PlaneMatch> matches;
  for (const XiaoPair& pair : solution.pairs) {
    PlaneMatch match{MakeFittedPlane(target.planes[pair.target]),
                     MakeFittedPlane(source.planes[pair.source])};
    // The search may have turned a plane whose side is unknown.
    const Eigen::Vector3d seen = solution.target_from_source.rotation * match.source.normal;
    if (seen.dot(match.target.normal) < 0) match.source.normal = -match.source.normal;
    matches.push_back(match);
  }
  return matches;
}

double Rms(const std::vector<PlaneMatch>& matches, const Rigid3& target_from_source) {
  double sum = 0.0;
  for (const PlaneMatch& m : matches) {
    const Eigen::Vector3d apart = target_from_source * m.source.centroid - m.target.centroid;
    sum += std::pow(m.target.normal.dot(apart), 2);
  }
  return std::sqrt(sum / static_cast<double>(std::max<std::size_t>(matches.size(), 1)));
}

const XiaoSolution* RunnerUp(const XiaoMatch& match) {
  for (std::size_t k = 1; k < match.solutions.size(); ++k) {
    if (Compete(match.solutions[0].target_from_source, match.solutions[k].target_from_source)) {
      return &match.solutions[k];
    }
  }
  return nullptr;
}

void Decide(const XiaoMatch& match, std::size_t least_pairs, Registration* result) {
  const XiaoSolution& best = match.solutions[0];
  const XiaoSolution* second = RunnerUp(match);
  if (best.pairs.size() < least_pairs) {
    result->status = RegistrationStatus::kFailed;
    result->reason = "only " + std::to_string(best.pairs.size()) + " pairs of planes agree";
  } else if (second != nullptr && second->pairs.size() >= best.pairs.size() &&
             second->area_product > kAmbiguousShare * best.area_product) {
    result->status = RegistrationStatus::kAmbiguous;
    result->reason = "another pose has as many pairs of planes";
  } else if (!result->unobserved.empty()) {
    result->status = RegistrationStatus::kDegenerate;
    result->reason = match.two_directions_only ? match.reason : "a direction is not observed";
  } else {
    result->status = RegistrationStatus::kOk;
  }
}

}  // namespace

Registration RegisterXiao(const PlaneSet& target, const PlaneSet& source,
                          const XiaoOptions& options) {
  Registration result;
  const XiaoMatch match = MatchXiao(target, source, options);
  result.reason = match.reason;
  if (match.solutions.empty()) return result;
  const XiaoSolution& best = match.solutions[0];
  const auto matches = MakeMatches(target, source, best);
  const ClosedFormPose pose = SolveClosedForm(matches);
  Refinement& refinement = result.refinement;
  refinement.target_from_source = pose.target_from_source;
  refinement.covariance = pose.covariance;
  refinement.information = pose.covariance.inverse();
  refinement.rms = Rms(matches, pose.target_from_source);
  refinement.converged = true;
  for (const XiaoPair& pair : best.pairs) {
    refinement.correspondences.push_back({pair.target, pair.source, 0});
  }
  const double most = static_cast<double>(std::max<std::size_t>(
      {CountLarge(target, options.min_area), CountLarge(source, options.min_area), 1}));
  result.quality = static_cast<double>(best.pairs.size()) / most;
  if (const XiaoSolution* second = RunnerUp(match)) {
    result.runner_up = static_cast<double>(second->pairs.size()) / most;
  }
  result.unobserved = pose.unobserved;
  Decide(match, match.two_directions_only ? 2 : 3, &result);
  return result;
}

}  // namespace planegraph
