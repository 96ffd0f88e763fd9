#include "correspondence/rotation_hypotheses.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "planegraph/base/angles.h"
#include "planegraph/geometry/rotation.h"

namespace planegraph {
namespace {

constexpr std::size_t kSeedDirections = 10;
constexpr double kAngleTolerance = 4.0 * kDegree;
constexpr double kLeastAngle = 25.0 * kDegree;  // a pair must not be parallel
const double kDistinct = std::cos(8.0 * kDegree);
const double kRange = 1.0 - std::cos(6.0 * kDegree);  // of a direction's partner

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

struct PairFrame {
  double angle;  // between the two
  Eigen::Matrix3d frame;
};

// Of every two of the heaviest directions; both ways round unless `once`.
std::vector<PairFrame> AllFrames(const std::vector<DirectionCluster>& directions, bool once) {
  std::vector<PairFrame> frames;
  const std::size_t n = std::min(kSeedDirections, directions.size());
  for (std::size_t a = 0; a < n; ++a) {
    for (std::size_t b = once ? a + 1 : 0; b < n; ++b) {
      if (a == b) continue;
      const Eigen::Vector3d &first = directions[a].direction, &second = directions[b].direction;
      frames.push_back({Angle(first, second), Frame(first, second)});
    }
  }
  return frames;
}

// Both sides' directions, the target's as rows, and what each pair of them may count.
class DirectionPairs {
 public:
  DirectionPairs(const std::vector<DirectionCluster>& target,
                 const std::vector<DirectionCluster>& source)
      : target_(target.size(), 3), source_(3, source.size()), slope_(target.size(), source.size()) {
    for (Eigen::Index t = 0; t < target_.rows(); ++t) target_.row(t) = target[t].direction;
    for (Eigen::Index s = 0; s < source_.cols(); ++s) source_.col(s) = source[s].direction;
    for (Eigen::Index s = 0; s < source_.cols(); ++s) {
      for (Eigen::Index t = 0; t < target_.rows(); ++t) {
        slope_(t, s) = std::min(target[t].weight, source[s].weight) / kRange;
      }
    }
    constant_ = (kRange - 1.0) * slope_;
  }

  // Every source direction with its best partner within six degrees; the share falls from one to
  // zero with the angle, so that the more exact of two rotations scores more.
  double Score(const Eigen::Matrix3d& rotation) {
    Share(rotation);
    return values_.colwise().maxCoeff().cwiseMax(0.0).sum();
  }

  // The rotation that fits all directions it brings together, not only the two it was made of.
  Eigen::Matrix3d Polish(const Eigen::Matrix3d& rotation) {
    Share(rotation);
    Eigen::Matrix3d sum = Eigen::Matrix3d::Zero();
    for (Eigen::Index s = 0; s < source_.cols(); ++s) {
      Eigen::Index t = 0;
      const double best = values_.col(s).maxCoeff(&t);
      if (best > 0.0) sum += best * target_.row(t).transpose() * source_.col(s).transpose();
    }
    return ProjectToRotation(sum);
  }

 private:
  // A pair counts min(weights) * (1 - (1 - cosine) / kRange).
  void Share(const Eigen::Matrix3d& rotation) {
    turned_.noalias() = rotation.lazyProduct(source_);
    values_.noalias() = target_.lazyProduct(turned_);
    values_.array() = constant_.array() + slope_.array() * values_.array();
  }

  Eigen::MatrixX3d target_;
  Eigen::Matrix3Xd source_, turned_;
  Eigen::MatrixXd slope_, constant_, values_;  // target x source
};

double CosineBetween(const Eigen::Matrix3d& a, const Eigen::Matrix3d& b) {
  return 0.5 * ((a.transpose() * b).trace() - 1.0);
}

std::vector<RotationHypothesis> Distinct(const std::vector<RotationHypothesis>& all,
                                         std::size_t most) {
  std::vector<std::pair<double, std::size_t>> order;
  for (std::size_t k = 0; k < all.size(); ++k) order.emplace_back(-all[k].score, k);
  std::sort(order.begin(), order.end());
  std::vector<RotationHypothesis> kept;
  for (const auto& [score, k] : order) {
    if (kept.size() == most) break;
    const bool known = std::any_of(kept.begin(), kept.end(), [&, k = k](const auto& other) {
      return CosineBetween(other.target_from_source, all[k].target_from_source) > kDistinct;
    });
    if (!known) kept.push_back(all[k]);
  }
  return kept;
}

}  // namespace

std::vector<RotationHypothesis> FindRotations(const std::vector<DirectionCluster>& target,
                                              const std::vector<DirectionCluster>& source,
                                              std::size_t most) {
  if (target.empty() || source.empty()) return {};
  DirectionPairs pairs(target, source);
  const auto to = AllFrames(target, false), from = AllFrames(source, true);
  std::vector<RotationHypothesis> all;
  for (const auto& s : from) {
    if (std::min(s.angle, std::numbers::pi - s.angle) < kLeastAngle) continue;
    for (const auto& t : to) {
      if (std::abs(t.angle - s.angle) > kAngleTolerance) continue;
      const Eigen::Matrix3d rotation = t.frame * s.frame.transpose();
      all.push_back({rotation, pairs.Score(rotation)});
    }
  }
  auto kept = Distinct(all, most);
  for (auto& rotation : kept) {
    rotation.target_from_source = pairs.Polish(rotation.target_from_source);
  }
  return kept;
}

}  // namespace planegraph
