#include "planegraph/registration/georeference.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <numbers>

#include "planegraph/base/error.h"
#include "planegraph/geometry/alignment.h"
#include "registration/georeference_noise.h"

namespace planegraph {
namespace {

constexpr int kRobustSamples = 1000;
constexpr std::size_t kLeastCameras = 3;

template <typename... Values>
std::string Format(const char* format, Values... values) {
  char text[400];
  std::snprintf(text, sizeof(text), format, values...);
  return text;
}

// ---- the clocks ----

// Looks for the offset at which positions and cameras fit best: coarse steps by the robust noise,
// then a parameter of the fit. Zero unless the data show another one clearly.
class ClockSearch {
 public:
  ClockSearch(const CameraPairing& pairing, const NoisePrior& prior,
              const GeoreferenceOptions& options)
      : pairing_(pairing), prior_(prior), options_(options) {}

  double Find() const {
    double offset = CoarseOffset(), sigma = 0.0;
    for (int round = 0; round < 3; ++round) {
      const std::vector<PositionPair> pairs = pairing_.Pairs(offset);
      if (pairs.size() < kLeastCameras + 1) return 0.0;
      const CorrelatedFit fit = Fit(pairs);
      offset += fit.time_correction;
      sigma = fit.sigma_time;
    }
    const bool clear = std::abs(offset) > kClear * sigma && std::abs(offset) > kLeast &&
                       std::abs(offset) <= options_.max_time_offset + kStep;
    return clear ? offset : 0.0;
  }

 private:
  static constexpr double kStep = 1.0, kClear = 4.0, kLeast = 0.02;  // seconds, sigmas, seconds
  static constexpr int kCoarseSamples = 100;

  // The offset with the least noise, where that is clearly less than at zero.
  double CoarseOffset() const {
    constexpr double kBetter = 0.8;
    const std::size_t enough = pairing_.Pairs(0.0).size() * 3 / 4;
    double best = 0.0, least = Noise(0.0, 0) * kBetter;
    const int steps = static_cast<int>(options_.max_time_offset / kStep);
    for (int step = -steps; step <= steps; ++step) {
      const double noise = Noise(step * kStep, enough);
      if (noise < least) {
        least = noise;
        best = step * kStep;
      }
    }
    return best;
  }
  double Noise(double offset, std::size_t enough) const {
    const auto pairs = pairing_.Pairs(offset);
    if (pairs.size() < std::max(enough, kLeastCameras + 1)) return INFINITY;
    const RobustFit fit = FitRobustly(pairs, prior_, options_.seed, kCoarseSamples);
    return std::cbrt(fit.sigma_horizontal * fit.sigma_horizontal * fit.sigma_vertical);
  }
  CorrelatedFit Fit(const std::vector<PositionPair>& pairs) const {
    const RobustFit robust = FitRobustly(pairs, prior_, options_.seed, kRobustSamples);
    std::vector<PositionPair> inliers;
    for (std::size_t i = 0; i < pairs.size(); ++i) {
      if (robust.inlier[i]) inliers.push_back(pairs[i]);
    }
    if (inliers.size() < kLeastCameras) return {};
    return FitCorrelated(inliers, robust.world_from_map, {prior_, true, true, true});
  }

  const CameraPairing& pairing_;
  NoisePrior prior_;
  const GeoreferenceOptions& options_;
};

// ---- the paper ----

double PathLength(const std::vector<PositionPair>& pairs,
                  const Eigen::Vector3d PositionPair::*position) {
  double length = 0.0;
  for (std::size_t i = 1; i < pairs.size(); ++i) {
    length += (pairs[i].*position - pairs[i - 1].*position).norm();
  }
  return length;
}

Sim3 AlignAsThePaper(const std::vector<PositionPair>& pairs) {
  const double in_map = PathLength(pairs, &PositionPair::in_map);
  const double in_world = PathLength(pairs, &PositionPair::in_world);
  const double scale = in_map > 0.0 && in_world > 0.0 ? in_world / in_map : 1.0;
  std::vector<Eigen::Vector3d> scaled, target;
  for (const auto& pair : pairs) {
    scaled.emplace_back(scale * pair.in_map);
    target.push_back(pair.in_world);
  }
  const Sim3 rigid = AlignPoints(scaled, target, false).target_from_source;
  return {scale, rigid.rotation, rigid.translation};
}

// ---- the result ----

class Georeferencer {
 public:
  Georeferencer(const CameraPairing& pairing, const GpsTrack& track,
                const GeoreferenceOptions& options)
      : pairing_(pairing), options_(options), prior_{!track.metric} {
    result_.origin = pairing.origin();
  }

  Georeference Run() {
    const bool paper = options_.method == "paper";
    if (paper) {
      TakePaperPairs();
    } else {
      TakeRobustPairs();
    }
    if (pairs_.size() < kLeastCameras) {
      Degenerate(Format("only %zu of %zu registered cameras have a position: 3 are needed",
                        pairs_.size(), pairing_.valid_cameras()));
    } else {
      if (paper) {
        FitAsThePaper();
      } else {
        FitRobust();
      }
      if (result_.has_estimate) Judge();
    }
    ListFixes();
    return std::move(result_);
  }

 private:
  void TakePaperPairs() {
    result_.time_offset = pairing_.day_shift();
    pairs_ = pairing_.NearestPairs();
  }
  void TakeRobustPairs() {
    double offset = 0.0;
    if (pairing_.by_time() && options_.max_time_offset > 0.0) {
      offset = ClockSearch(pairing_, prior_, options_).Find();
    }
    result_.time_offset = offset + pairing_.day_shift();
    pairs_ = pairing_.Pairs(offset);
  }
  void FitAsThePaper() {
    inlier_.assign(pairs_.size(), true);
    Adopt(FitCorrelated(pairs_, AlignAsThePaper(pairs_), WhiteNoise()));
    result_.world_from_map = AlignAsThePaper(pairs_);
  }
  void FitRobust() {
    const RobustFit robust = FitRobustly(pairs_, prior_, options_.seed, kRobustSamples);
    inlier_ = robust.inlier;
    if (Inliers().size() < kLeastCameras) {
      result_.reason = "no three positions agree on one similarity";
      return;
    }
    Adopt(FitCorrelated(Inliers(), robust.world_from_map,
                        {prior_, pairing_.has_times(), false, true}));
  }
  CorrelationOptions WhiteNoise() const { return {prior_, pairing_.has_times(), false, false}; }
  std::vector<PositionPair> Inliers() const {
    std::vector<PositionPair> inliers;
    for (std::size_t i = 0; i < pairs_.size(); ++i) {
      if (inlier_[i]) inliers.push_back(pairs_[i]);
    }
    return inliers;
  }
  void Adopt(const CorrelatedFit& fit) {
    result_.world_from_map = fit.world_from_map;
    result_.covariance = fit.covariance;
    result_.sigma_scale = std::sqrt(fit.covariance(6, 6));
    result_.sigma_horizontal = fit.sigma_horizontal;
    result_.sigma_vertical = fit.sigma_vertical;
    result_.correlation_inflation = fit.inflation;
    const Sim3& s = fit.world_from_map;
    result_.has_estimate = s.rotation.coeffs().allFinite() && s.translation.allFinite() &&
                           std::isfinite(s.scale) && s.scale > 0.0 && fit.covariance.allFinite();
    if (!result_.has_estimate) result_.reason = "the fit of the similarity did not converge";
  }

  // Root mean squares of the positions about their centre along their main directions, metres,
  // ascending.
  Eigen::Vector3d Spread() const {
    const auto inliers = Inliers();
    Eigen::Vector3d mean = Eigen::Vector3d::Zero();
    for (const auto& pair : inliers) mean += pair.in_map;
    mean /= static_cast<double>(inliers.size());
    Eigen::Matrix3d scatter = Eigen::Matrix3d::Zero();
    for (const auto& pair : inliers) {
      scatter += (pair.in_map - mean) * (pair.in_map - mean).transpose();
    }
    scatter /= static_cast<double>(inliers.size());
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(scatter, Eigen::EigenvaluesOnly);
    return result_.world_from_map.scale * solver.eigenvalues().cwiseMax(0.0).cwiseSqrt();
  }
  double SigmaRotation() const {
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(
        Eigen::Matrix3d(result_.covariance.block<3, 3>(3, 3)), Eigen::EigenvaluesOnly);
    return std::sqrt(solver.eigenvalues()[2]);
  }

  void Degenerate(const std::string& reason) {
    result_.status = "degenerate";
    result_.reason = reason;
  }
  // Scale and rotation must be known; the second spread is what holds the rotation about the first.
  void Judge() {
    constexpr double kStraight = 1e-5;  // of the length: rounding
    constexpr double kNoise = 1.5;  // a spread of so many sigmas may be noise of the model itself
    const Eigen::Vector3d spread = Spread();
    const double noise = result_.sigma_horizontal;
    const double sigma_rotation = SigmaRotation();
    result_.status = "ok";
    if (!(result_.sigma_scale <= options_.max_sigma_scale)) {
      Degenerate(
          Format("the positions are clustered: they spread %.3g m (rms) with a noise of %.3g "
                 "m, so the scale is known to %.3g %% only",
                 spread[2], noise, 100.0 * result_.sigma_scale));
    } else if (spread[1] <= std::max(kStraight * spread[2], kNoise * noise) ||
               sigma_rotation > options_.max_sigma_rotation) {
      Degenerate(
          Format("the positions lie on a straight line: they spread %.3g m (rms) along it and "
                 "%.3g m across with a noise of %.3g m, so the rotation about it is open",
                 spread[2], spread[1], noise));
    }
  }

  void ListFixes() {
    double squares = 0.0;
    for (std::size_t i = 0; i < pairs_.size(); ++i) {
      const auto& pair = pairs_[i];
      const bool inlier = result_.has_estimate && inlier_[i];
      result_.fixes.push_back({pair.camera, pair.in_map, pair.in_world, inlier});
      if (!inlier) continue;
      result_.inliers.push_back(pair.camera);
      squares += (result_.world_from_map * pair.in_map - pair.in_world).squaredNorm();
    }
    std::sort(result_.inliers.begin(), result_.inliers.end());
    std::sort(result_.fixes.begin(), result_.fixes.end(),
              [](const CameraFix& a, const CameraFix& b) { return a.camera < b.camera; });
    if (result_.inliers.empty()) return;
    result_.rms = std::sqrt(squares / static_cast<double>(result_.inliers.size()));
  }

  const CameraPairing& pairing_;
  const GeoreferenceOptions& options_;
  NoisePrior prior_;
  std::vector<PositionPair> pairs_;
  std::vector<bool> inlier_;
  Georeference result_;
};

}  // namespace

Georeference ComputeGeoreference(const CameraModel& model, const GpsTrack& track,
                                 const std::optional<ImageTimes>& times,
                                 const GeoreferenceOptions& options) {
  if (options.method != "robust" && options.method != "paper") {
    throw UsageError("the method must be robust or paper, not '" + options.method + "'");
  }
  const CameraPairing pairing(model, track, times, options);
  return Georeferencer(pairing, track, options).Run();
}

}  // namespace planegraph
