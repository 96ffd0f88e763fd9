#include "planegraph/pipeline/pairing.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <numbers>
#include <set>
#include <utility>

#include "planegraph/base/chi_square.h"
#include "planegraph/base/median.h"
#include "planegraph/base/parallel.h"
#include "planegraph/geometry/rotation.h"
#include "planegraph/graph/pose_error.h"

namespace planegraph {
namespace {

constexpr double kDegree = std::numbers::pi / 180.0;
// A pose from the odometry that explains this much needs no search for another one.
constexpr double kGoodQuality = 0.3, kGoodDirection = 0.8;
constexpr double kCandidateGate = 0.5;     // metres: how far off the chained poses may be
constexpr double kCandidateSupport = 0.2;  // share of the surfaces that must be common

double Seconds(std::chrono::steady_clock::time_point start) {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

bool Usable(const Registration& r) {
  return r.status == RegistrationStatus::kOk || r.status == RegistrationStatus::kDegenerate;
}

// The prior of odometry only matters where the surfaces leave something open; elsewhere even a
// wrong one must not pull.
PosePrior WeakPrior(const Rigid3& guess) { return {guess, 1e4 * Matrix6d::Identity()}; }

Registration RegisterStep(const ScanModel& target, const ScanModel& source,
                          const OdometryStep* odometry, const RegistrationOptions& options) {
  if (odometry == nullptr) return Register(target, source, options);
  Registration near =
      RegisterFromGuess(target, source, WeakPrior(odometry->target_from_source), options);
  if (near.quality >= kGoodQuality && near.support.WorstDirection() >= kGoodDirection) return near;
  Registration far = Register(target, source, options);
  return Usable(far) && far.quality > near.quality ? far : near;
}

const OdometryStep* FindStep(const std::vector<OdometryStep>& steps, std::size_t target) {
  const auto found = std::find_if(steps.begin(), steps.end(),
                                  [&](const OdometryStep& s) { return s.target == target; });
  return found == steps.end() ? nullptr : &*found;
}

// Where the planes leave a direction open the odometry decides on it.
void HoldOpenDirections(const ScanModel& target, const ScanModel& source, const OdometryStep& step,
                        const RegistrationOptions& options, Registration* registration) {
  if (registration->unobserved.empty()) return;
  Registration held =
      RegisterFromGuess(target, source, {step.target_from_source, step.covariance}, options);
  held.unobserved = registration->unobserved;
  for (auto& open : held.unobserved) open.held_by = "odometry";
  held.status = registration->status;
  held.reason = registration->reason;
  *registration = std::move(held);
}

// How many of the odometry's standard deviations (of three axes together) the pose is off, by
// translation or by rotation, whichever is more.
double Contradiction(const Rigid3& target_from_source, const OdometryStep& step) {
  const Vector6d off = PoseError(target_from_source, step.target_from_source);
  const auto chi2 = [&](int at) {
    return off.segment<3>(at).dot(
        step.covariance.block<3, 3>(at, at).ldlt().solve(off.segment<3>(at)));
  };
  return std::sqrt(std::max(chi2(0), chi2(3)));
}

// Beyond all chance: one in a million of good odometry.
double MostContradiction() { return std::sqrt(ChiSquareQuantile(1.0 - 1e-6, 3)); }

void Refuse(const OdometryStep& step, PairRecord* pair) {
  const Eigen::Vector3d off =
      pair->registration.target_from_source().translation - step.target_from_source.translation;
  char text[160];
  std::snprintf(text, sizeof(text),
                "it contradicts the odometry: %.2f m off, %.0f standard deviations", off.norm(),
                Contradiction(pair->registration.target_from_source(), step));
  pair->registration.status = RegistrationStatus::kAmbiguous;
  pair->registration.reason = text;
  pair->used = false;
}

struct Candidate {
  std::size_t target, source;
  double support;
};

std::vector<Candidate> FindCandidates(const std::vector<ScanModel>& models,
                                      const std::vector<Rigid3>& poses,
                                      const std::vector<int>& frames,
                                      const std::set<std::pair<std::size_t, std::size_t>>& known) {
  std::vector<Candidate> candidates;
  for (std::size_t i = 0; i < models.size(); ++i) {
    for (std::size_t j = i + 1; j < models.size(); ++j) {
      if (frames[i] != frames[j] || known.count({i, j})) continue;
      const Rigid3 guess = poses[i].Inverse() * poses[j];
      const double support = MeasureSupport(models[i], models[j], guess, kCandidateGate).agree;
      if (support >= kCandidateSupport) candidates.push_back({i, j, support});
    }
  }
  std::stable_sort(candidates.begin(), candidates.end(),
                   [](const auto& a, const auto& b) { return a.support > b.support; });
  return candidates;
}

constexpr std::size_t kLeastSteps = 3;  // for a robust scale

double RobustScale(std::vector<double> ratios) {
  if (ratios.size() < kLeastSteps) return 1.0;
  // Median of chi-square with three degrees of freedom over three.
  return std::max(1.0, Median(std::move(ratios)) / 0.789);
}

}  // namespace

Matrix6d OdometryCovariance(const Rigid3& target_from_source) {
  const double distance = target_from_source.translation.norm();
  const double turn = LogSO3(target_from_source.rotation).norm();
  const double translation = 0.02 + 0.05 * distance;
  const double rotation = 0.5 * kDegree + 0.05 * turn + 0.5 * kDegree * distance;
  Matrix6d covariance = Matrix6d::Zero();
  covariance.topLeftCorner<3, 3>().diagonal().setConstant(translation * translation);
  covariance.bottomRightCorner<3, 3>().diagonal().setConstant(rotation * rotation);
  return covariance;
}

std::vector<OdometryStep> OdometrySteps(const Site& site, const std::vector<ScanRecord>& scans) {
  std::vector<OdometryStep> steps;
  for (std::size_t i = 0; i + 1 < scans.size(); ++i) {
    const RobotSite& robot = site.robots[scans[i].robot];
    if (scans[i + 1].robot != scans[i].robot || !robot.odometry) continue;
    const auto& poses = robot.odometry->poses;
    const Rigid3 step = poses[scans[i].index].Inverse() * poses[scans[i + 1].index];
    steps.push_back({i, i + 1, step, OdometryCovariance(step)});
  }
  return steps;
}

bool CalibrateOdometry(const std::vector<PairRecord>& pairs, std::vector<OdometryStep>* steps) {
  std::vector<double> translation, rotation;
  for (const PairRecord& pair : pairs) {
    const OdometryStep* step = FindStep(*steps, pair.target);
    if (!pair.used || step == nullptr || step->source != pair.source) continue;
    if (pair.registration.status != RegistrationStatus::kOk) continue;
    const Rigid3& seen = pair.registration.target_from_source();
    translation.push_back((seen.translation - step->target_from_source.translation).squaredNorm() /
                          step->covariance.topLeftCorner<3, 3>().trace());
    const double angle = AngleBetween(seen.rotation, step->target_from_source.rotation);
    rotation.push_back(angle * angle / step->covariance.bottomRightCorner<3, 3>().trace());
  }
  const bool calibrated = translation.size() >= kLeastSteps;
  const double ft = RobustScale(std::move(translation)), fr = RobustScale(std::move(rotation));
  for (OdometryStep& step : *steps) {
    step.covariance.topLeftCorner<3, 3>() *= ft;
    step.covariance.bottomRightCorner<3, 3>() *= fr;
  }
  return calibrated;
}

std::vector<PairRecord> RegisterChain(const std::vector<ScanModel>& models,
                                      const std::vector<ScanRecord>& scans,
                                      const std::vector<OdometryStep>& odometry,
                                      const RegistrationOptions& options, int threads) {
  std::vector<PairRecord> chain;
  for (std::size_t i = 0; i + 1 < scans.size(); ++i) {
    if (scans[i].robot == scans[i + 1].robot) chain.push_back({i, i + 1, {}, false, 0.0});
  }
  ParallelFor(chain.size(), threads, [&](std::size_t k) {
    const auto start = std::chrono::steady_clock::now();
    PairRecord& pair = chain[k];
    const OdometryStep* step = FindStep(odometry, pair.target);
    const ScanModel &target = models[pair.target], &source = models[pair.source];
    pair.registration = RegisterStep(target, source, step, options);
    if (step != nullptr && Usable(pair.registration)) {
      HoldOpenDirections(target, source, *step, options, &pair.registration);
    }
    pair.used = Usable(pair.registration);
    pair.seconds = Seconds(start);
  });
  return chain;
}

void ResolveContradictions(const std::vector<ScanModel>& models,
                           const std::vector<OdometryStep>& odometry,
                           const RegistrationOptions& options, int threads,
                           std::vector<PairRecord>* chain) {
  ParallelFor(chain->size(), threads, [&](std::size_t k) {
    PairRecord& pair = (*chain)[k];
    const OdometryStep* step = FindStep(odometry, pair.target);
    if (step == nullptr || !pair.used) return;
    const double most = MostContradiction();
    if (Contradiction(pair.registration.target_from_source(), *step) <= most) return;
    const ScanModel &target = models[pair.target], &source = models[pair.source];
    Registration near =
        RegisterFromGuess(target, source, WeakPrior(step->target_from_source), options);
    if (!Usable(near) || Contradiction(near.target_from_source(), *step) > most) {
      Refuse(*step, &pair);
      return;
    }
    HoldOpenDirections(target, source, *step, options, &near);
    pair.registration = std::move(near);
  });
}

std::vector<PairRecord> RegisterNeighbours(const std::vector<ScanModel>& models,
                                           const std::vector<Rigid3>& world_from_scan,
                                           const std::vector<int>& frames,
                                           const std::vector<PairRecord>& known,
                                           const RegistrationOptions& options,
                                           std::size_t most_per_scan, int threads) {
  std::set<std::pair<std::size_t, std::size_t>> done;
  for (const auto& pair : known) done.insert({pair.target, pair.source});
  std::vector<std::size_t> count(models.size(), 0);
  std::vector<PairRecord> pairs;
  for (const Candidate& c : FindCandidates(models, world_from_scan, frames, done)) {
    if (count[c.target] >= most_per_scan && count[c.source] >= most_per_scan) continue;
    ++count[c.target], ++count[c.source];
    pairs.push_back({c.target, c.source, {}, false, 0.0});
  }
  ParallelFor(pairs.size(), threads, [&](std::size_t k) {
    const auto start = std::chrono::steady_clock::now();
    PairRecord& pair = pairs[k];
    const Rigid3 guess = world_from_scan[pair.target].Inverse() * world_from_scan[pair.source];
    pair.registration =
        RegisterFromGuess(models[pair.target], models[pair.source], WeakPrior(guess), options);
    pair.used = Usable(pair.registration);
    pair.seconds = Seconds(start);
  });
  return pairs;
}

}  // namespace planegraph
