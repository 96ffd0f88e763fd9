#include "planegraph/registration/registration.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>

#include "planegraph/geometry/rotation.h"
#include "registration/competing_poses.h"

namespace planegraph {
namespace {

// A standard deviation that means "nothing is known".
constexpr double kInfinite = 100.0;

// A rotation known worse than this (radians) is tried from other starts, turned by kTurn.
constexpr double kWeakEnoughToTurn = 0.002, kTurn = 0.1;

// Surfels that tell hypotheses apart, and the share of the best one's quality from which on one is
// refined by all surfels: well below the share that makes an answer ambiguous.
constexpr std::size_t kFewSurfels = 400;
constexpr double kMayCompete = 0.5;

struct Candidate {
  Refinement refinement;
  Support support;
  double quality;
};

std::string Format(const char* format, double a, double b = 0.0) {
  char text[160];
  std::snprintf(text, sizeof(text), format, a, b);
  return text;
}

double SupportGate(const Refinement& refinement, const RegistrationOptions& options) {
  return std::max(options.support_gate, 3.0 * refinement.floor);
}

Candidate Evaluate(const ScanModel& target, const ScanModel& source, Refinement refinement,
                   const RegistrationOptions& options) {
  Candidate c{std::move(refinement), {}, 0.0};
  c.support = MeasureSupport(target, source, c.refinement.target_from_source,
                             SupportGate(c.refinement, options));
  c.quality = Quality(c.support);
  return c;
}

// A start metres off can still be centimetres off when the iterations end, too little for the
// quality to tell. Goes on from there, unless that loses evidence: then it drifts along a weak
// direction.
Candidate Settle(const ScanModel& target, const ScanModel& source, Candidate best,
                 const RegistrationOptions& options) {
  constexpr double kTwoSamples = 0.01;  // of the quality: nothing that the samples could tell
  if (best.refinement.converged) return best;
  Candidate further = Evaluate(
      target, source,
      RefinePose(target, source, best.refinement.target_from_source, options.refinement), options);
  return further.quality > best.quality - kTwoSamples ? further : best;
}

double RunnerUp(const std::vector<Candidate>& candidates) {
  for (std::size_t k = 1; k < candidates.size(); ++k) {
    if (Compete(candidates[0].refinement.target_from_source,
                candidates[k].refinement.target_from_source)) {
      return candidates[k].quality;
    }
  }
  return 0.0;
}

UnobservedDirection MakeOpen(int first, const Eigen::Vector3d& axis, double sigma) {
  UnobservedDirection open;
  open.direction.setZero();
  open.direction.segment<3>(first) = axis;
  open.sigma = sigma > kInfinite ? std::numeric_limits<double>::infinity() : sigma;
  return open;
}

// Information on the translation when the rotation is free, too.
Eigen::Matrix3d TranslationInformation(const Matrix6d& information) {
  const Eigen::Matrix3d rotation =
      information.bottomRightCorner<3, 3>() + 1e-9 * Eigen::Matrix3d::Identity();
  const Eigen::Matrix3d cross = information.topRightCorner<3, 3>();
  return information.topLeftCorner<3, 3>() - cross * rotation.ldlt().solve(cross.transpose());
}

// The direction that the surfaces face least; the covariance's own axis leans to it under what
// translation and rotation share.
Eigen::Vector3d LeastFaced(const Matrix6d& information, const Eigen::Vector3d& axis) {
  constexpr double kNear = 0.94;  // 20 degrees
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> eigen(
      Eigen::Matrix3d(information.topLeftCorner<3, 3>()));
  const Eigen::Vector3d least = eigen.eigenvectors().col(0);
  if (std::abs(least.dot(axis)) < kNear) return axis;
  return least.dot(axis) < 0 ? Eigen::Vector3d(-least) : least;
}

bool IsFaked(const ScanModel& target, const ScanModel& source, const Refinement& refinement,
             const Eigen::Vector3d& axis, double sigma, const RegistrationOptions& options) {
  constexpr double kLeastShare = 0.3;
  const Eigen::Matrix3d information = TranslationInformation(refinement.information);
  if (axis.dot(information * axis) <= 9.0 * axis.dot(refinement.spurious * axis)) return true;
  const double shift = std::clamp(4.0 * sigma, 0.1, 0.4);
  return ObservedShare(target, source, refinement, axis, shift, options.refinement) < kLeastShare;
}

void AddOpenTranslations(const ScanModel& target, const ScanModel& source, const Support& support,
                         const Refinement& refinement, const RegistrationOptions& options,
                         std::vector<UnobservedDirection>* found) {
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> eigen(
      Eigen::Matrix3d(refinement.covariance.topLeftCorner<3, 3>()));
  bool observed = false;
  for (int k = 2; k >= 0; --k) {
    const double sigma = std::sqrt(std::max(eigen.eigenvalues()[k], 0.0));
    const Eigen::Vector3d axis = LeastFaced(refinement.information, eigen.eigenvectors().col(k));
    // Along a corridor some frame or pipe always fits something, and looks sharp.
    if (!support.IsFaced(axis)) {
      found->push_back(MakeOpen(0, axis, INFINITY));
      continue;
    }
    // Better observed axes than one that is observed need no closer look.
    if (observed) continue;
    if (IsFaked(target, source, refinement, axis, sigma, options)) {
      found->push_back(MakeOpen(0, axis, INFINITY));
    } else if (sigma > options.weak_translation) {
      found->push_back(MakeOpen(0, axis, sigma));
    } else {
      observed = true;
    }
  }
}

void AddOpenRotations(const Refinement& refinement, double limit,
                      std::vector<UnobservedDirection>* found) {
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> eigen(
      Eigen::Matrix3d(refinement.covariance.bottomRightCorner<3, 3>()));
  for (int k = 2; k >= 0; --k) {
    const double sigma = std::sqrt(std::max(eigen.eigenvalues()[k], 0.0));
    if (sigma > limit) found->push_back(MakeOpen(3, eigen.eigenvectors().col(k), sigma));
  }
}

std::string DescribeUnobserved(const std::vector<UnobservedDirection>& unobserved) {
  std::string text;
  for (const auto& open : unobserved) {
    const bool translation = open.direction.head<3>().norm() > 0.5;
    const Eigen::Vector3d axis = translation ? open.direction.head<3>() : open.direction.tail<3>();
    char part[160];
    std::snprintf(part, sizeof(part), "%s%s (%.2f, %.2f, %.2f) is not observed",
                  text.empty() ? "" : "; ", translation ? "translation along" : "rotation about",
                  axis.x(), axis.y(), axis.z());
    text += part;
  }
  return text;
}

// A small part of a scan can agree with the wrong place of a large one by chance; then hardly any
// of the large one agrees with it.
void RequireBothWays(const ScanModel& target, const ScanModel& source,
                     const RegistrationOptions& options, Registration* result) {
  const Rigid3 source_from_target = result->target_from_source().Inverse();
  const double gate = SupportGate(result->refinement, options);
  result->quality_back = Quality(MeasureSupport(source, target, source_from_target, gate));
  if (*result->quality_back >= options.least_quality) return;
  if (result->status == RegistrationStatus::kFailed) return;
  result->status = RegistrationStatus::kFailed;
  result->reason = Format("the other way round the pose explains too little: quality %.2f of %.2f",
                          *result->quality_back, options.least_quality);
}

void Decide(const RegistrationOptions& options, Registration* result) {
  if (result->quality < options.least_quality) {
    result->status = RegistrationStatus::kFailed;
    result->reason = Format("the best pose explains too little: quality %.2f of %.2f",
                            result->quality, options.least_quality);
  } else if (result->runner_up > options.ambiguity * result->quality) {
    result->status = RegistrationStatus::kAmbiguous;
    result->reason = Format("another pose explains nearly as much: quality %.2f against %.2f",
                            result->runner_up, result->quality);
  } else if (result->unobserved.size() >= 6) {
    result->status = RegistrationStatus::kFailed;
    result->reason = "the surfaces in common observe no direction of the pose";
  } else if (!result->unobserved.empty()) {
    result->status = RegistrationStatus::kDegenerate;
    result->reason = DescribeUnobserved(result->unobserved);
  } else {
    result->status = RegistrationStatus::kOk;
  }
}

// Scans that share few surfaces of some direction can fit in two ways a few degrees apart, each of
// which looks sharp by itself. Refines from the pose turned about its two least known axes.
std::vector<Candidate> RefineTurned(const ScanModel& target, const ScanModel& source,
                                    const Refinement& best, const RegistrationOptions& options) {
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> eigen(
      Eigen::Matrix3d(best.covariance.bottomRightCorner<3, 3>()));
  std::vector<Candidate> found;
  if (!(eigen.eigenvalues()[2] > kWeakEnoughToTurn * kWeakEnoughToTurn)) return found;
  for (const int axis : {1, 2}) {
    for (const double turn : {-kTurn, kTurn}) {
      Rigid3 start = best.target_from_source;
      start.rotation = ExpSO3(turn * eigen.eigenvectors().col(axis)) * start.rotation;
      found.push_back(
          Evaluate(target, source, RefinePose(target, source, start, options.refinement), options));
    }
  }
  return found;
}

// Keeps the best of a pose and its neighbours. The others that explain nearly as much are part of
// what is not known: their differences enter the covariance, by their share of the quality.
Candidate MergeNeighbours(Candidate best, std::vector<Candidate> neighbours,
                          const RegistrationOptions& options) {
  for (Candidate& other : neighbours) {
    if (other.quality > best.quality) std::swap(best, other);
  }
  const Rigid3 pose = best.refinement.target_from_source;
  for (const Candidate& other : neighbours) {
    const Rigid3& rival = other.refinement.target_from_source;
    if (!(other.quality > options.ambiguity * best.quality) || Compete(pose, rival)) continue;
    Eigen::Matrix<double, 6, 1> difference;
    difference << rival.translation - pose.translation,
        LogSO3(rival.rotation * pose.rotation.conjugate());
    best.refinement.covariance +=
        other.quality / (other.quality + best.quality) * difference * difference.transpose();
  }
  return best;
}

// All hypotheses by few surfels, those that could win or compete by all of them.
std::vector<Candidate> RefineHypotheses(const ScanModel& target, const ScanModel& source,
                                        const RegistrationOptions& options) {
  const auto refine = [&](const Rigid3& start, const RefinementOptions& refinement) {
    return Evaluate(target, source, RefinePose(target, source, start, refinement), options);
  };
  RefinementOptions few = options.refinement;
  few.most_surfels = std::min(few.most_surfels, kFewSurfels);
  std::vector<Candidate> candidates;
  std::vector<Rigid3> starts;
  double best = 0.0;
  for (const auto& h : FindHypotheses(target, source, options.hypotheses)) {
    if (!h.rejected.empty()) continue;
    starts.push_back(h.target_from_source);
    candidates.push_back(refine(starts.back(), few));
    best = std::max(best, candidates.back().quality);
  }
  for (std::size_t k = 0; k < starts.size(); ++k) {
    if (candidates[k].quality < kMayCompete * best) continue;
    candidates[k] = refine(starts[k], options.refinement);
  }
  return candidates;
}

Registration Finish(const ScanModel& target, const ScanModel& source, Candidate best,
                    double runner_up, const RegistrationOptions& options) {
  Registration result;
  result.refinement = std::move(best.refinement);
  result.support = best.support;
  result.quality = best.quality;
  result.runner_up = runner_up;
  result.unobserved = FindUnobserved(target, source, result.support, result.refinement, options);
  Decide(options, &result);
  return result;
}

}  // namespace

const char* ToString(RegistrationStatus status) {
  switch (status) {
    case RegistrationStatus::kOk:
      return "ok";
    case RegistrationStatus::kDegenerate:
      return "degenerate";
    case RegistrationStatus::kAmbiguous:
      return "ambiguous";
    case RegistrationStatus::kFailed:
      return "failed";
  }
  return "failed";
}

double Quality(const Support& support) {
  return std::max(0.0, support.Score()) * support.WorstDirection();
}

std::vector<UnobservedDirection> FindUnobserved(const ScanModel& target, const ScanModel& source,
                                                const Support& support,
                                                const Refinement& refinement,
                                                const RegistrationOptions& options) {
  std::vector<UnobservedDirection> found;
  AddOpenTranslations(target, source, support, refinement, options, &found);
  AddOpenRotations(refinement, options.weak_rotation, &found);
  return found;
}

Registration Register(const ScanModel& target, const ScanModel& source,
                      const RegistrationOptions& options) {
  std::vector<Candidate> candidates = RefineHypotheses(target, source, options);
  if (candidates.empty()) {
    Registration none;
    none.reason = "the two scans have no two plane directions at equal angles";
    return none;
  }
  std::stable_sort(candidates.begin(), candidates.end(),
                   [](const auto& a, const auto& b) { return a.quality > b.quality; });
  const double runner_up = RunnerUp(candidates);
  Candidate best = Settle(target, source, std::move(candidates[0]), options);
  auto neighbours = RefineTurned(target, source, best.refinement, options);
  best = MergeNeighbours(std::move(best), std::move(neighbours), options);
  RegistrationOptions alone = options;
  alone.least_quality = std::max(options.least_quality, options.least_quality_alone);
  Registration result = Finish(target, source, std::move(best), runner_up, alone);
  RequireBothWays(target, source, options, &result);
  return result;
}

Registration RegisterFromGuess(const ScanModel& target, const ScanModel& source,
                               const PosePrior& guess, const RegistrationOptions& options) {
  Refinement refinement =
      RefinePose(target, source, guess.target_from_source, options.refinement, guess);
  return Finish(target, source, Evaluate(target, source, std::move(refinement), options), 0.0,
                options);
}

}  // namespace planegraph
