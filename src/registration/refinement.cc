#include "planegraph/registration/refinement.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <map>
#include <utility>
#include <vector>

#include "planegraph/base/median.h"
#include "planegraph/geometry/rotation.h"

namespace planegraph {
namespace {

using Vector6d = Eigen::Matrix<double, 6, 1>;

// From this gate on the association is good enough to measure the noise floor, metres.
constexpr double kCalibrationGate = 0.15;

// Information that stands for none: a standard deviation of a kilometre, or of 1000 radians.
constexpr double kRidge = 1e-6;

struct Normal {
  Matrix6d information = Matrix6d::Zero();  // with the robust weights
  Vector6d gradient = Vector6d::Zero();
  Eigen::Matrix3d spurious = Eigen::Matrix3d::Zero();
  // By segment of the target: sums of weight * jacobian times 1 and the two in-plane coordinates
  // about its centroid, the effect of a common error of its height and of its two tilts.
  std::map<std::int32_t, Eigen::Matrix<double, 6, 3>> by_segment;
  std::map<std::pair<std::int32_t, std::int32_t>, int> plane_pairs;
  std::vector<double> squares, variances;  // of the residuals, and what the noise model expects
  int pairs = 0;

  // Robust variance of the residuals: the median of squares of a normal distribution is 0.455 of
  // it.
  double Variance() { return Median(squares) / 0.455; }
  // What the noise model does not explain: bent scans, rough walls.
  double Unexplained() { return Variance() - Median(variances); }
};

// The part of the weight's variance that lies in the direction of each axis of translation: what
// the normal's own error would add to the information.
Eigen::Matrix3d NormalCovariance(const Surfel& s) {
  return s.variance1 * s.axis1 * s.axis1.transpose() + s.variance2 * s.axis2 * s.axis2.transpose();
}

class Refiner {
 public:
  Refiner(const ScanModel& target, const ScanModel& source, const RefinementOptions& options,
          const std::optional<PosePrior>& prior)
      : target_(target),
        source_(source),
        options_(options),
        stride_(1 + source.map.surfels().size() / std::max<std::size_t>(options.most_surfels, 1)) {
    if (prior) prior_ = *prior;
    if (prior) prior_information_ = prior->covariance.inverse();
  }

  Refinement Run(Rigid3 pose) const;

 private:
  Normal Linearize(const Rigid3& pose, double gate, double floor_variance, bool detailed) const;
  void AddDetails(const Surfel& target, const Surfel& source, double weight,
                  const Vector6d& jacobian, Normal* out) const;
  void MeasureTilts(const Rigid3& pose, const Normal& normal, Refinement* result) const;
  void AddPrior(const Rigid3& pose, Normal* normal) const;
  Vector6d Step(const Normal& normal) const;
  void Summarize(Normal last, const Rigid3& pose, double floor, Refinement* result) const;

  const ScanModel& target_;
  const ScanModel& source_;
  const RefinementOptions& options_;
  std::size_t stride_;
  PosePrior prior_;
  Matrix6d prior_information_ = Matrix6d::Zero();
};

Normal Refiner::Linearize(const Rigid3& pose, double gate, double floor_variance,
                          bool detailed) const {
  Normal out;
  const Eigen::Matrix3d rotation = pose.rotation.toRotationMatrix();
  // Wide gates come with poor rotations; narrow ones ask for surfaces that face alike.
  const double least_cosine = gate > 0.2 ? 0.94 : 0.97;
  const auto& surfels = source_.map.surfels();
  for (std::size_t i = 0; i < surfels.size(); i += stride_) {
    const Eigen::Vector3d arm = rotation * surfels[i].mean;
    const Eigen::Vector3d point = arm + pose.translation;
    const int found = target_.map.Find(point, rotation * surfels[i].normal, gate, least_cosine);
    if (found < 0) continue;
    const Surfel& surface = target_.map.surfels()[found];
    const double residual = surface.normal.dot(point - surface.mean);
    const double modelled = surface.HeightVariance(point) + surfels[i].offset_variance;
    const double variance = modelled + floor_variance;
    const double width = std::max(gate * gate / 9.0, 9.0 * variance);
    const double robust = std::pow(width / (width + residual * residual), 2);
    const double weight = robust / variance;
    Vector6d jacobian;
    jacobian << surface.normal, arm.cross(surface.normal);
    out.information.noalias() += weight * jacobian * jacobian.transpose();
    out.gradient.noalias() += weight * residual * jacobian;
    if (detailed) AddDetails(surface, surfels[i], weight, jacobian, &out);
    out.squares.push_back(residual * residual);
    out.variances.push_back(modelled);
    out.pairs++;
  }
  return out;
}

void Refiner::AddDetails(const Surfel& target, const Surfel& source, double weight,
                         const Vector6d& jacobian, Normal* out) const {
  out->spurious += weight * NormalCovariance(target);
  if (target.segment < 0) return;
  const PlaneSegment& segment = target_.planes->planes[target.segment];
  const Eigen::Vector3d arm = target.mean - segment.centroid();
  const Eigen::Vector3d shares(1.0, segment.axes.vectors.col(1).dot(arm),
                               segment.axes.vectors.col(2).dot(arm));
  out->by_segment.try_emplace(target.segment, Eigen::Matrix<double, 6, 3>::Zero()).first->second +=
      weight * jacobian * shares.transpose();
  if (source.segment >= 0) out->plane_pairs[{target.segment, source.segment}]++;
}

void Refiner::AddPrior(const Rigid3& pose, Normal* normal) const {
  Vector6d difference;
  difference << pose.translation - prior_.target_from_source.translation,
      LogSO3(pose.rotation * prior_.target_from_source.rotation.conjugate());
  normal->information += prior_information_;
  normal->gradient += prior_information_ * difference;
}

Vector6d Refiner::Step(const Normal& normal) const {
  // A millionth of the mean information keeps open directions where they are.
  Matrix6d damped = normal.information;
  for (int k = 0; k < 6; ++k) {
    const double mean =
        (k < 3 ? damped.topLeftCorner<3, 3>() : damped.bottomRightCorner<3, 3>()).trace() / 3.0;
    damped(k, k) += 1e-6 * mean + 1e-9;
  }
  return -damped.ldlt().solve(normal.gradient);
}

Refinement Refiner::Run(Rigid3 pose) const {
  Refinement result;
  const double least_floor = options_.floor_offset * options_.floor_offset;
  double gate = options_.first_gate, last_gate = options_.last_gate, floor = least_floor;
  for (; result.iterations < options_.most_iterations; ++result.iterations) {
    Normal normal = Linearize(pose, gate, floor, false);
    if (gate <= kCalibrationGate) {
      // The surfaces themselves say how well they can agree.
      floor = std::max(least_floor, normal.Unexplained());
      last_gate =
          std::clamp(4.0 * std::sqrt(normal.Variance()), options_.last_gate, kCalibrationGate);
    }
    AddPrior(pose, &normal);
    const Vector6d step = Step(normal);
    pose.rotation = (ExpSO3(step.tail<3>()) * pose.rotation).normalized();
    pose.translation += step.head<3>();
    const bool small = step.head<3>().norm() < 1e-4 && step.tail<3>().norm() < 2e-5;
    if (small && gate <= last_gate) {
      result.converged = true;
      break;
    }
    gate = std::max(last_gate, 0.7 * gate);
  }
  Summarize(Linearize(pose, gate, floor, true), pose, floor, &result);
  return result;
}

// Tilt between the planes that were paired, and what of it is beyond what their own covariances
// explain: the median again, over both in-plane axes of pairs that several surfels have confirmed.
void Refiner::MeasureTilts(const Rigid3& pose, const Normal& normal, Refinement* result) const {
  constexpr int kConfirmed = 4;
  std::vector<double> squares, expected;
  for (const auto& [pair, count] : normal.plane_pairs) {
    if (count < kConfirmed) continue;
    const PlaneSegment& t = target_.planes->planes[pair.first];
    const PlaneSegment& s = source_.planes->planes[pair.second];
    const Eigen::Vector3d source_normal = pose.rotation * s.plane.normal;
    for (int k = 1; k <= 2; ++k) {
      squares.push_back(std::pow(t.axes.vectors.col(k).dot(source_normal), 2));
      expected.push_back(t.covariance(k - 1, k - 1) + s.covariance(k - 1, k - 1));
    }
  }
  if (squares.size() < 8) return;
  const double variance = Median(squares) / 0.455;
  result->tilt_rms = std::sqrt(variance);
  result->tilt_floor = std::sqrt(std::max(0.0, variance - Median(expected)));
}

void Refiner::Summarize(Normal last, const Rigid3& pose, double floor, Refinement* result) const {
  result->target_from_source = pose;
  result->information = last.information;
  result->spurious = last.spurious;
  result->pairs = last.pairs;
  result->floor = std::sqrt(floor);
  result->rms = std::sqrt(last.Variance());
  MeasureTilts(pose, last, result);
  const Eigen::Vector3d variances(floor, std::pow(result->tilt_floor, 2),
                                  std::pow(result->tilt_floor, 2));
  Matrix6d shared = Matrix6d::Zero();
  for (const auto& [segment, sums] : last.by_segment) {
    shared += sums * variances.asDiagonal() * sums.transpose();
  }
  const Matrix6d total = last.information + prior_information_ + kRidge * Matrix6d::Identity();
  const Matrix6d inverse = total.ldlt().solve(Matrix6d::Identity());
  result->covariance = inverse + inverse * shared * inverse;
  for (const auto& [pair, count] : last.plane_pairs) {
    if (count >= 2) result->correspondences.push_back({pair.first, pair.second, count});
  }
  std::stable_sort(result->correspondences.begin(), result->correspondences.end(),
                   [](const auto& a, const auto& b) { return a.surfels > b.surfels; });
}

}  // namespace

Refinement RefinePose(const ScanModel& target, const ScanModel& source,
                      const Rigid3& target_from_source, const RefinementOptions& options,
                      const std::optional<PosePrior>& prior) {
  return Refiner(target, source, options, prior).Run(target_from_source);
}

double ObservedShare(const ScanModel& target, const ScanModel& source, const Refinement& refinement,
                     const Eigen::Vector3d& direction, double shift,
                     const RefinementOptions& options) {
  constexpr double kCap = 9.0;  // of a normalized square: a surface without a partner costs as much
  constexpr double kGate = 0.15, kLeastCosine = 0.97;
  const Eigen::Matrix3d rotation = refinement.target_from_source.rotation.toRotationMatrix();
  const double floor = std::pow(std::max(refinement.floor, options.floor_offset), 2);
  const auto cost = [&](const Eigen::Vector3d& point, const Surfel& surfel, int partner) {
    if (partner < 0) return kCap;
    const Surfel& surface = target.map.surfels()[partner];
    const double variance = surface.HeightVariance(point) + surfel.offset_variance + floor;
    return std::min(kCap, std::pow(surface.normal.dot(point - surface.mean), 2) / variance);
  };
  double predicted = 0.0, actual = 0.0;
  const auto& surfels = source.map.surfels();
  const std::size_t stride = 1 + surfels.size() / std::max<std::size_t>(options.most_surfels, 1);
  for (std::size_t i = 0; i < surfels.size(); i += stride) {
    const Eigen::Vector3d normal = rotation * surfels[i].normal;
    const Eigen::Vector3d point =
        rotation * surfels[i].mean + refinement.target_from_source.translation;
    const int partner = target.map.Find(point, normal, kGate, kLeastCosine);
    if (partner < 0) continue;
    const double here = cost(point, surfels[i], partner);
    for (const double step : {-shift, shift}) {
      const Eigen::Vector3d moved = point + step * direction;
      // A surface that leaves what the target saw says nothing: only another surface or the same
      // one counts, or free space.
      const int found = target.map.Find(moved, normal, kGate, kLeastCosine);
      predicted += cost(moved, surfels[i], partner) - here;
      if (found >= 0 || std::abs(normal.dot(direction)) > 0.5) {
        actual += cost(moved, surfels[i], found) - here;
      }
    }
  }
  return predicted > 0.0 ? actual / predicted : 1.0;
}

}  // namespace planegraph
