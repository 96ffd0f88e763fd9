#include "planegraph/evaluation/trajectory_warnings.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstdarg>
#include <cstdio>

#include "planegraph/base/angles.h"
#include "planegraph/base/median.h"
#include "planegraph/geometry/moments.h"
#include "planegraph/geometry/rotation.h"

namespace planegraph {
namespace {

[[gnu::format(printf, 1, 2)]] std::string Format(const char* format, ...) {
  char text[512];
  std::va_list arguments;
  va_start(arguments, format);
  std::vsnprintf(text, sizeof text, format, arguments);
  va_end(arguments);
  return text;
}

// ---- one file ----

// Rounding to three decimals moves a norm by 0.001 at most.
constexpr double kNormTolerance = 1e-3;

bool StartsWithWFirst(const Trajectory& trajectory) {
  if (!trajectory.has_times || trajectory.size() == 0) return false;
  const Eigen::Quaterniond& q = trajectory.poses.front().rotation;
  return std::abs(q.x()) > 1.0 - 1e-6;
}

// ---- two files ----

// Another way to read the four numbers of a quaternion.
struct Reading {
  bool w_first, inverted;
  const char* name;
};
constexpr Reading kReadings[] = {{true, true, "w first and inverted, as 3DTK's frames2tum writes"},
                                 {true, false, "w first"},
                                 {false, true, "inverted (body from world)"}};

std::vector<Eigen::Quaterniond> Rotations(const std::vector<MatrixPose>& poses) {
  std::vector<Eigen::Quaterniond> rotations;
  for (const MatrixPose& pose : poses) {
    rotations.emplace_back(Eigen::Quaterniond(pose.rotation).normalized());
  }
  return rotations;
}

std::vector<Eigen::Quaterniond> ReadAs(const Reading& reading, std::vector<Eigen::Quaterniond> q) {
  for (Eigen::Quaterniond& r : q) {
    if (reading.w_first) r = Eigen::Quaterniond(r.x(), r.y(), r.z(), r.w());
    if (reading.inverted) r = r.conjugate();
  }
  return q;
}

// Median angle between the rotations from pose to pose, near ones and far ones.
double Disagreement(const std::vector<Eigen::Quaterniond>& a,
                    const std::vector<Eigen::Quaterniond>& b) {
  std::vector<double> angles;
  for (const std::size_t step : {std::size_t{1}, a.size() / 4, a.size() / 2}) {
    if (step == 0) continue;
    for (std::size_t i = 0; i + step < a.size(); ++i) {
      angles.push_back(
          AngleBetween(a[i].conjugate() * a[i + step], b[i].conjugate() * b[i + step]));
    }
  }
  return Median(std::move(angles));
}

// Noise lets the right reading be a little worse than a wrong one where the body hardly turns, but
// not twice; and below half a degree nothing is to be told.
constexpr double kFarBetter = 0.5, kLeastDisagreement = 0.01;

// The better reading of one of two lists of rotations, and how far they then disagree.
struct BetterReading {
  const Reading* reading = nullptr;
  double as_read = 0.0, angle = 0.0;  // radians
};

BetterReading FindReading(const std::vector<Eigen::Quaterniond>& suspect,
                          const std::vector<Eigen::Quaterniond>& other) {
  BetterReading best;
  best.as_read = Disagreement(suspect, other);
  best.angle = kFarBetter * best.as_read;
  if (!(best.as_read > kLeastDisagreement)) return best;
  for (const Reading& reading : kReadings) {
    const double angle = Disagreement(ReadAs(reading, suspect), other);
    if (!(angle < best.angle)) continue;
    best.angle = angle;
    best.reading = &reading;
  }
  return best;
}

// Between two TUM files the rotations alone do not tell which of them is the wrong one; the first
// quaternion may.
std::string Suspect(const Trajectory& reference, const std::string& reference_file,
                    const Trajectory& estimate, const std::string& estimate_file) {
  if (!reference.has_times) return estimate_file;
  if (!estimate.has_times) return reference_file;
  if (StartsWithWFirst(estimate) == StartsWithWFirst(reference)) {
    return estimate_file + " or " + reference_file;
  }
  return StartsWithWFirst(estimate) ? estimate_file : reference_file;
}

void WarnOfReading(const BetterReading& better, const std::string& file,
                   std::vector<std::string>* warnings) {
  if (!better.reading) return;
  warnings->push_back(
      file + ": the rotations between poses agree with the other trajectory to " +
      Format("%.2f instead of %.2f degrees", kDegreesPerRadian * better.angle,
             kDegreesPerRadian * better.as_read) +
      " when its quaternions are read " + better.reading->name +
      "; TUM is qx qy qz qw, world from body. RPE and rotation errors mean nothing as they stand "
      "(convert 3DTK poses by planegraph convert)");
}

// ---- places ----

struct Spread {
  double along, across;  // metres, root mean square about the mean
};

Spread SpreadOf(const std::vector<MatrixPose>& poses) {
  Moments moments;
  for (const MatrixPose& pose : poses) moments.Add(pose.translation);
  const Eigen::Vector3d values =
      (ComputePrincipalAxes(moments.scatter).values / moments.count).cwiseMax(0.0).cwiseSqrt();
  return {values[2], values[1]};
}

bool AlignsPositions(const AteResult& ate) {
  return ate.alignment == PoseAlignment::kSe3 || ate.alignment == PoseAlignment::kSim3;
}

// An alignment by positions fits d of their 3n coordinates, which takes a share of the errors.
void WarnOfCount(const AteResult& ate, std::vector<std::string>* warnings) {
  constexpr double kShare = 0.05;
  constexpr std::size_t kFew = 10;
  const std::size_t count = ate.errors.count;
  const double freedom = ate.alignment == PoseAlignment::kSim3 ? 7.0 : 6.0;
  const double rest = std::max(0.0, 1.0 - freedom / (3.0 * static_cast<double>(count)));
  if (AlignsPositions(ate) && 1.0 - std::sqrt(rest) > kShare) {
    warnings->push_back(
        Format("%zu poses: the alignment takes %.0f of their %zu coordinates and "
               "makes ATE smaller by about %.0f %%; see RPE and --align=first, too",
               count, freedom, 3 * count, 100.0 * (1.0 - std::sqrt(rest))));
  } else if (count < kFew) {
    warnings->push_back(Format("%zu poses are too few to tell one estimate from another", count));
  }
}

void WarnOfLine(const PosePairs& pairs, const AteResult& ate, std::vector<std::string>* warnings) {
  constexpr double kMostSigma = 1.0;  // degrees
  const Spread spread = SpreadOf(pairs.reference);
  const double error = ate.errors.translation.rmse;
  if (spread.along < 3.0 * error) {
    warnings->push_back(
        Format("clustered: the positions lie within %.3g m (rms) of each other, and "
               "their errors are %.3g m",
               spread.along, error));
  } else if (AlignsPositions(ate)) {
    const double sigma = kDegreesPerRadian * error /
                         std::sqrt(3.0 * static_cast<double>(ate.errors.count)) /
                         std::max(spread.across, 1e-12);
    if (sigma < kMostSigma) return;
    warnings->push_back(
        Format("the positions nearly lie on a line (%.3g m along, %.3g m across): "
               "the alignment's rotation about it is known to %.1f degrees",
               spread.along, spread.across, sigma));
  }
}

Eigen::Vector3d MedianPosition(const std::vector<MatrixPose>& poses) {
  Eigen::Vector3d result;
  for (int axis = 0; axis < 3; ++axis) {
    std::vector<double> values;
    for (const MatrixPose& pose : poses) values.push_back(pose.translation[axis]);
    result[axis] = Median(std::move(values));
  }
  return result;
}

void WarnOfStanding(const PosePairs& pairs, std::vector<std::string>* warnings) {
  constexpr double kPlace = 0.05;
  const Eigen::Vector3d middle = MedianPosition(pairs.reference);
  double farthest = 0.0;
  for (const auto& pose : pairs.reference) {
    farthest = std::max(farthest, (pose.translation - middle).norm());
  }
  std::size_t near = 0;
  for (const auto& pose : pairs.reference) {
    near += (pose.translation - middle).norm() < kPlace * farthest ? 1 : 0;
  }
  if (2 * near <= pairs.reference.size()) return;
  warnings->push_back(
      Format("clustered: %zu of %zu poses stand within %.3g m of one place and carry "
             "the figures",
             near, pairs.reference.size(), kPlace * farthest));
}

}  // namespace

std::optional<std::string> TimesWarning(const Trajectory& trajectory, const std::string& file) {
  if (!trajectory.has_times) return std::nullopt;
  std::size_t wrong = 0, first = 0;
  for (std::size_t i = 1; i < trajectory.size(); ++i) {
    if (trajectory.times[i] > trajectory.times[i - 1]) continue;
    if (wrong++ == 0) first = i;
  }
  if (wrong == 0) return std::nullopt;
  return file + Format(": %zu times do not increase, first that of pose %zu (counted from 0)",
                       wrong, first);
}

std::vector<std::string> FileWarnings(const Trajectory& trajectory, const std::string& file) {
  std::vector<std::string> warnings;
  if (const auto times = TimesWarning(trajectory, file)) warnings.push_back(*times);
  if (trajectory.norm_error > kNormTolerance) {
    warnings.push_back(file + Format(": quaternions are not normalized, a norm is off by %.2g",
                                     trajectory.norm_error));
  }
  if (StartsWithWFirst(trajectory)) {
    warnings.push_back(file +
                       ": the first quaternion is `1 0 0 0`, the identity with w first as 3DTK's "
                       "frames2tum writes it (and inverted); TUM is qx qy qz qw. Right only if the "
                       "body starts upside down");
  }
  return warnings;
}

std::vector<std::string> PairingWarnings(const Trajectory& reference,
                                         const std::string& reference_file,
                                         const Trajectory& estimate,
                                         const std::string& estimate_file, const PosePairs& pairs) {
  constexpr double kManyUnpaired = 0.1;
  std::vector<std::string> warnings;
  const std::size_t fewer = std::min(reference.size(), estimate.size());
  if (static_cast<double>(pairs.unpaired) > kManyUnpaired * static_cast<double>(fewer)) {
    warnings.push_back(
        Format("%zu of %zu poses of the shorter trajectory have no counterpart in "
               "time; nothing is said of them",
               pairs.unpaired, fewer));
  }
  if (!estimate.has_times && !reference.has_times) return warnings;  // no quaternions in the files
  const auto of_reference = Rotations(pairs.reference), of_estimate = Rotations(pairs.estimate);
  const BetterReading better = estimate.has_times ? FindReading(of_estimate, of_reference)
                                                  : FindReading(of_reference, of_estimate);
  WarnOfReading(better, Suspect(reference, reference_file, estimate, estimate_file), &warnings);
  return warnings;
}

std::vector<std::string> PlacementWarnings(const PosePairs& pairs, const AteResult& ate) {
  std::vector<std::string> warnings;
  WarnOfCount(ate, &warnings);
  WarnOfLine(pairs, ate, &warnings);
  WarnOfStanding(pairs, &warnings);
  return warnings;
}

}  // namespace planegraph
