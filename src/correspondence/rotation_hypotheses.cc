#include "correspondence/rotation_hypotheses.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "planegraph/geometry/rotation.h"

namespace planegraph {
namespace {

constexpr double kDegree = std::numbers::pi / 180.0;
constexpr std::size_t kSeedDirections = 10;
constexpr double kAngleTolerance = 4.0 * kDegree;
constexpr double kLeastAngle = 25.0 * kDegree;  // a pair must not be parallel
const double kDistinct = std::cos(8.0 * kDegree);

double Angle(const Eigen::Vector3d& a, const Eigen::Vector3d& b) {
  return std::atan2(a.cross(b).norm(), a.dot(b));
}

Eigen::Matrix3d Frame(const Eigen::Vector3d& a, const Eigen::Vector3d& b) {
  // The bisectors of the pair, so that an error of the angle is shared between both.
  Eigen::Matrix3d frame;
  frame.col(0) = (a + b).normalized();
  frame.col(2) = a.cross(b).normalized();
  frame.col(1) = frame.col(2).cross(frame.col(0));
  return frame;
}

// Calls visit(source, target, share) for every source direction with its best partner within six
// degrees; the share falls from one to zero with the angle, so that the more exact of two rotations
// scores more.
template <typename Visit>
void ForPartners(const Eigen::Matrix3d& rotation, const std::vector<DirectionCluster>& target,
                 const std::vector<DirectionCluster>& source, Visit visit) {
  static const double kRange = 1.0 - std::cos(6.0 * kDegree);
  for (const auto& s : source) {
    const Eigen::Vector3d d = rotation * s.direction;
    const DirectionCluster* partner = nullptr;
    double best = 0.0;
    for (const auto& t : target) {
      const double share = 1.0 - (1.0 - t.direction.dot(d)) / kRange;
      const double value = share * std::min(s.weight, t.weight);
      if (value > best) best = value, partner = &t;
    }
    if (partner != nullptr) visit(s, *partner, best);
  }
}

double Score(const Eigen::Matrix3d& rotation, const std::vector<DirectionCluster>& target,
             const std::vector<DirectionCluster>& source) {
  double score = 0.0;
  ForPartners(rotation, target, source,
              [&](const auto&, const auto&, double value) { score += value; });
  return score;
}

// The rotation that fits all directions it brings together, not only the two it was made of.
Eigen::Matrix3d Polish(const Eigen::Matrix3d& rotation, const std::vector<DirectionCluster>& target,
                       const std::vector<DirectionCluster>& source) {
  Eigen::Matrix3d sum = Eigen::Matrix3d::Zero();
  ForPartners(rotation, target, source, [&](const auto& s, const auto& t, double value) {
    sum += value * t.direction * s.direction.transpose();
  });
  return ProjectToRotation(sum);
}

double CosineBetween(const Eigen::Matrix3d& a, const Eigen::Matrix3d& b) {
  return 0.5 * ((a.transpose() * b).trace() - 1.0);
}

std::vector<RotationHypothesis> Distinct(std::vector<RotationHypothesis> all, std::size_t most) {
  std::stable_sort(all.begin(), all.end(),
                   [](const auto& a, const auto& b) { return a.score > b.score; });
  std::vector<RotationHypothesis> kept;
  for (const auto& candidate : all) {
    if (kept.size() == most) break;
    const bool known = std::any_of(kept.begin(), kept.end(), [&](const auto& k) {
      return CosineBetween(k.target_from_source, candidate.target_from_source) > kDistinct;
    });
    if (!known) kept.push_back(candidate);
  }
  return kept;
}

}  // namespace

std::vector<RotationHypothesis> FindRotations(const std::vector<DirectionCluster>& target,
                                              const std::vector<DirectionCluster>& source,
                                              std::size_t most) {
  std::vector<RotationHypothesis> all;
  const std::size_t n = std::min(kSeedDirections, source.size());
  const std::size_t m = std::min(kSeedDirections, target.size());
  for (std::size_t a = 0; a < n; ++a) {
    for (std::size_t b = a + 1; b < n; ++b) {
      const double angle = Angle(source[a].direction, source[b].direction);
      if (std::min(angle, std::numbers::pi - angle) < kLeastAngle) continue;
      const Eigen::Matrix3d from = Frame(source[a].direction, source[b].direction);
      for (std::size_t c = 0; c < m; ++c) {
        for (std::size_t d = 0; d < m; ++d) {
          if (c == d) continue;
          const double other = Angle(target[c].direction, target[d].direction);
          if (std::abs(other - angle) > kAngleTolerance) continue;
          const Eigen::Matrix3d rotation =
              Frame(target[c].direction, target[d].direction) * from.transpose();
          all.push_back({rotation, Score(rotation, target, source)});
        }
      }
    }
  }
  auto kept = Distinct(std::move(all), most);
  for (auto& rotation : kept) {
    rotation.target_from_source = Polish(rotation.target_from_source, target, source);
  }
  return kept;
}

}  // namespace planegraph
