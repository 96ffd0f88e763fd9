#include "planegraph/pipeline/chain.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <utility>

#include "pipeline/lap.h"
#include "pipeline/registering.h"
#include "planegraph/base/chi_square.h"
#include "planegraph/base/median.h"
#include "planegraph/base/parallel.h"
#include "planegraph/geometry/rotation.h"
#include "planegraph/graph/pose_error.h"

namespace planegraph {
namespace {

// A pose from the odometry that explains this much needs no search for another one.
constexpr double kGoodQuality = 0.3, kGoodDirection = 0.8;

Registration RegisterStep(const ScanModel& target, const ScanModel& source,
                          const OdometryStep* odometry, const RegistrationOptions& options) {
  if (odometry == nullptr) return Register(target, source, options);
  Registration near =
      RegisterFromGuess(target, source, WeakPrior(odometry->target_from_source), options);
  if (near.quality >= kGoodQuality && near.support.WorstDirection() >= kGoodDirection) return near;
  Registration far = Register(target, source, options);
  return Usable(far) && far.quality > near.quality ? far : near;
}

// Where the planes leave a direction open the odometry decides on it.
void HoldByOdometry(const ScanModel& target, const ScanModel& source, const OdometryStep& step,
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

// How many standard deviations (of three axes together) the pose is off the odometry, by
// translation or by rotation, whichever is more. A step's covariance grows with its way, which need
// not be how this odometry errs: what all steps scatter by counts as well.
double Contradiction(const Rigid3& target_from_source, const OdometryStep& step,
                     const OdometryScatter& scatter) {
  const Vector6d off = PoseError(target_from_source, step.target_from_source);
  const auto sigmas = [&](int at, double sigma) {
    const Eigen::Vector3d part = off.segment<3>(at);
    const double chi2 = part.dot(step.covariance.block<3, 3>(at, at).ldlt().solve(part));
    return std::min(std::sqrt(chi2), part.norm() / sigma);
  };
  return std::max(sigmas(0, scatter.translation), sigmas(3, scatter.rotation));
}

// Beyond all chance: one in a million of good odometry.
double MostContradiction() { return std::sqrt(ChiSquareQuantile(1.0 - 1e-6, 3)); }

void Refuse(const OdometryStep& step, double contradiction, PairRecord* pair) {
  const Eigen::Vector3d off =
      pair->registration.target_from_source().translation - step.target_from_source.translation;
  char text[160];
  std::snprintf(text, sizeof(text),
                "it contradicts the odometry: %.2f m off, %.0f standard deviations", off.norm(),
                contradiction);
  pair->registration.status = RegistrationStatus::kAmbiguous;
  pair->registration.reason = text;
  pair->used = false;
}

// A refinement looks for partners no farther than its first gate. By how much the odometry
// displaces surfaces grows with their distance.
bool IsWithinReach(const OdometryScatter& scatter, const ScanModel& source,
                   const RefinementOptions& options) {
  double sum = 0.0;
  for (const std::uint32_t k : source.samples) sum += source.map.surfels()[k].mean.squaredNorm();
  const double range =
      std::sqrt(sum / std::max<double>(1.0, static_cast<double>(source.samples.size())));
  return 3.0 * std::hypot(scatter.translation, scatter.rotation * range) <= options.first_gate;
}

void SearchBeyondReach(const ScanModel& target, const ScanModel& source,
                       const OdometryScatter& scatter, const RegistrationOptions& options,
                       PairRecord* pair) {
  if (IsWithinReach(scatter, source, options.refinement)) return;
  Registration far = Register(target, source, options);
  if (!Usable(far) || (pair->used && far.quality <= pair->registration.quality)) return;
  pair->registration = std::move(far);
  pair->used = true;
}

void ResolveContradiction(const ScanModel& target, const ScanModel& source,
                          const OdometryStep& step, const OdometryScatter& scatter,
                          const RegistrationOptions& options, PairRecord* pair) {
  const double most = MostContradiction();
  const double found = Contradiction(pair->registration.target_from_source(), step, scatter);
  if (!pair->used || found <= most) return;
  Registration near =
      RegisterFromGuess(target, source, WeakPrior(step.target_from_source), options);
  if (Usable(near) && Contradiction(near.target_from_source(), step, scatter) <= most) {
    pair->registration = std::move(near);
  } else {
    Refuse(step, found, pair);
  }
}

constexpr std::size_t kLeastSteps = 3;  // for a robust scale

// Medians of chi-square and of chi with three degrees of freedom.
constexpr double kMedianChi2 = 2.366, kMedianChi = 1.538;

double RobustScale(std::vector<double> ratios) {
  if (ratios.size() < kLeastSteps) return 1.0;
  return std::max(1.0, Median(std::move(ratios)) / (kMedianChi2 / 3.0));
}

double RobustSigma(std::vector<double> lengths) {
  if (lengths.size() < kLeastSteps) return 0.0;
  return Median(std::move(lengths)) / kMedianChi;
}

// A factor that all lengths are off by.
Matrix6d CommonCovariance(const Eigen::Vector3d& translation, double sigma_scale) {
  Matrix6d common = Matrix6d::Zero();
  common.topLeftCorner<3, 3>() = sigma_scale * sigma_scale * translation * translation.transpose();
  return common;
}

}  // namespace

Matrix6d OdometryStep::OwnCovariance() const {
  return covariance - CommonCovariance(target_from_source.translation, sigma_scale);
}

void OdometryStep::Scale(double factor) {
  const Matrix6d own = OwnCovariance();
  target_from_source.translation *= factor;
  covariance = own + CommonCovariance(target_from_source.translation, sigma_scale);
}

Matrix6d OdometryCovariance(const Rigid3& target_from_source, const OdometryNoise& noise) {
  const double distance = target_from_source.translation.norm();
  const double turn = LogSO3(target_from_source.rotation).norm();
  const double translation = noise.step + noise.per_metre * distance;
  const double rotation =
      noise.step_rotation + noise.per_turn * turn + noise.rotation_per_metre * distance;
  Matrix6d covariance = Matrix6d::Zero();
  covariance.topLeftCorner<3, 3>().diagonal().setConstant(translation * translation);
  covariance.bottomRightCorner<3, 3>().diagonal().setConstant(rotation * rotation);
  return covariance + CommonCovariance(target_from_source.translation, noise.scale);
}

std::vector<OdometryStep> OdometrySteps(const Site& site, const std::vector<ScanRecord>& scans) {
  std::vector<OdometryStep> steps;
  for (std::size_t i = 0; i + 1 < scans.size(); ++i) {
    const RobotSite& robot = site.robots[scans[i].robot];
    if (scans[i + 1].robot != scans[i].robot || !robot.odometry) continue;
    const auto& poses = robot.odometry->poses;
    const Rigid3 step = poses[scans[i].index].Inverse() * poses[scans[i + 1].index];
    steps.push_back({i, i + 1, step, OdometryCovariance(step, robot.odometry_noise), scans[i].robot,
                     robot.odometry_noise.scale});
  }
  return steps;
}

const OdometryStep* FindStep(const std::vector<OdometryStep>& steps, const PairRecord& pair) {
  const auto found = std::lower_bound(
      steps.begin(), steps.end(), pair.target,
      [](const OdometryStep& step, std::size_t target) { return step.target < target; });
  const bool is_it =
      found != steps.end() && found->target == pair.target && found->source == pair.source;
  return is_it ? &*found : nullptr;
}

OdometryScatter CalibrateOdometry(const std::vector<PairRecord>& chain,
                                  std::vector<OdometryStep>* steps) {
  std::vector<double> metres, radians, translation, rotation;
  for (const PairRecord& pair : chain) {
    const OdometryStep* step = FindStep(*steps, pair);
    if (!pair.used || step == nullptr) continue;
    if (pair.registration.status != RegistrationStatus::kOk) continue;
    const Vector6d off =
        PoseError(pair.registration.target_from_source(), step->target_from_source);
    metres.push_back(off.head<3>().norm());
    radians.push_back(off.tail<3>().norm());
    translation.push_back(off.head<3>().squaredNorm() /
                          step->covariance.topLeftCorner<3, 3>().trace());
    rotation.push_back(off.tail<3>().squaredNorm() /
                       step->covariance.bottomRightCorner<3, 3>().trace());
  }
  const double ft = RobustScale(std::move(translation)), fr = RobustScale(std::move(rotation));
  for (OdometryStep& step : *steps) {
    step.covariance.topLeftCorner<3, 3>() *= ft;
    step.covariance.bottomRightCorner<3, 3>() *= fr;
    step.sigma_scale *= std::sqrt(ft);
  }
  return {RobustSigma(std::move(metres)), RobustSigma(std::move(radians))};
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
    PairRecord& pair = chain[k];
    const Lap lap(&pair.seconds);
    pair.registration =
        RegisterStep(models[pair.target], models[pair.source], FindStep(odometry, pair), options);
    pair.used = Usable(pair.registration);
  });
  return chain;
}

void ReviseChain(const std::vector<ScanModel>& models, const std::vector<OdometryStep>& odometry,
                 const OdometryScatter& scatter, const RegistrationOptions& options, int threads,
                 std::vector<PairRecord>* chain) {
  ParallelFor(chain->size(), threads, [&](std::size_t k) {
    PairRecord& pair = (*chain)[k];
    const OdometryStep* step = FindStep(odometry, pair);
    if (step == nullptr) return;
    const Lap lap(&pair.seconds);
    const ScanModel &target = models[pair.target], &source = models[pair.source];
    if (scatter.is_known()) {
      SearchBeyondReach(target, source, scatter, options, &pair);
      ResolveContradiction(target, source, *step, scatter, options, &pair);
    }
    if (pair.used) HoldByOdometry(target, source, *step, options, &pair.registration);
  });
}

}  // namespace planegraph
