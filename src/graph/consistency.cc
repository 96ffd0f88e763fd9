#include "planegraph/graph/consistency.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <map>
#include <stdexcept>

#include "graph/largest_clique.h"
#include "graph/trusted_ways.h"
#include "planegraph/base/chi_square.h"
#include "planegraph/base/disjoint_sets.h"
#include "planegraph/geometry/rotation.h"
#include "planegraph/graph/pose_error.h"

namespace planegraph {
namespace {

using Ways = std::vector<std::optional<Way>>;

struct Cycle {
  double chi2 = 0.0, uncertainty = 0.0;
};

void CheckIndices(int poses, const std::vector<RelativePose>& closures) {
  for (const RelativePose& closure : closures) {
    if (std::min(closure.target, closure.source) < 0 ||
        std::max(closure.target, closure.source) >= poses) {
      throw std::invalid_argument("a closure of a pose that is not there");
    }
  }
}

// What another closure says of this one, with the ways between their targets and sources.
std::optional<Cycle> CloseCycle(const RelativePose& closure, const std::optional<Way>& of_targets,
                                const RelativePose& other, const std::optional<Way>& of_sources) {
  if (!of_targets || !of_sources) return {};
  const RelativePose said = Compose(Compose(of_targets->pose, other), Inverse(of_sources->pose));
  return Cycle{DisagreementChi2(said, closure), said.covariance.trace()};
}

// The more certain one of the two cycles that two closures can make. Absent: none.
std::optional<Cycle> CycleOf(const RelativePose& closure, const Ways& from_target,
                             const Ways& from_source, const RelativePose& other) {
  const auto along =
      CloseCycle(closure, from_target[other.target], other, from_source[other.source]);
  const auto against =
      CloseCycle(closure, from_target[other.source], Inverse(other), from_source[other.target]);
  if (!along || !against) return along ? along : against;
  return along->uncertainty <= against->uncertainty ? along : against;
}

// Of the closures only those are compared in the clique that contradict some other: most of a graph
// of thousands agree with all.
class PairwiseConsistency {
 public:
  PairwiseConsistency(int poses, const std::vector<RelativePose>& trusted,
                      const std::vector<RelativePose>& closures, const ConsistencyOptions& options)
      : limit_(ChiSquareQuantile(options.confidence, 6)),
        by_way_(closures.size(), 0.0),
        conflicts_(closures.size()) {
    const TrustedWays ways(poses, trusted);
    for (std::size_t p = 0; p < closures.size(); ++p) {
      const Ways from_target = ways.From(closures[p].target);
      const Ways from_source = ways.From(closures[p].source);
      if (const auto& way = from_target[closures[p].source]) {
        by_way_[p] = DisagreementChi2(way->pose, closures[p]) / options.variance_factor;
      }
      for (std::size_t q = p + 1; q < closures.size(); ++q) {
        const auto cycle = CycleOf(closures[p], from_target, from_source, closures[q]);
        const double chi2 = cycle ? cycle->chi2 / options.variance_factor : 0.0;
        if (!(chi2 <= limit_)) conflicts_[p][q] = conflicts_[q][p] = chi2;
      }
    }
  }

  ConsistentSet Solve(int most_steps) const {
    ConsistentSet set;
    set.consistent.assign(by_way_.size(), false);
    std::vector<std::size_t> contested;
    for (std::size_t p = 0; p < by_way_.size(); ++p) {
      if (!AgreesWithWay(p)) continue;
      set.consistent[p] = !IsContested(p);
      if (!set.consistent[p]) contested.push_back(p);
    }
    for (const std::size_t p : LargestConsistent(contested, most_steps)) set.consistent[p] = true;
    for (std::size_t p = 0; p < by_way_.size(); ++p) {
      if (!set.consistent[p]) set.refused.push_back(Explain(p, set.consistent));
    }
    return set;
  }

 private:
  bool AgreesWithWay(std::size_t p) const { return by_way_[p] <= limit_; }
  bool IsContested(std::size_t p) const {
    return std::any_of(conflicts_[p].begin(), conflicts_[p].end(),
                       [this](const auto& conflict) { return AgreesWithWay(conflict.first); });
  }

  std::vector<std::size_t> LargestConsistent(const std::vector<std::size_t>& contested,
                                             int most_steps) const {
    std::vector<std::vector<bool>> agree(contested.size(), std::vector<bool>(contested.size()));
    for (std::size_t a = 0; a < contested.size(); ++a) {
      for (std::size_t b = 0; b < contested.size(); ++b) {
        agree[a][b] = a != b && conflicts_[contested[a]].count(contested[b]) == 0;
      }
    }
    std::vector<std::size_t> chosen;
    for (const std::size_t a : LargestClique(agree, most_steps)) chosen.push_back(contested[a]);
    return chosen;
  }

  Inconsistency Explain(std::size_t p, const std::vector<bool>& consistent) const {
    Inconsistency reason;
    reason.measurement = p;
    reason.limit = limit_;
    reason.with_way = !AgreesWithWay(p);
    reason.chi2 = by_way_[p];
    for (const auto& [q, chi2] : conflicts_[p]) {
      if (!consistent[q]) continue;
      reason.against.push_back(q);
      reason.chi2 = std::max(reason.chi2, chi2);
    }
    return reason;
  }

  double limit_;
  std::vector<double> by_way_;  // chi2 of each closure against the way; 0: there is none
  std::vector<std::map<std::size_t, double>> conflicts_;  // of each closure: chi2 beyond the limit
};

}  // namespace

RelativePose Compose(const RelativePose& a, const RelativePose& b) {
  const Eigen::Matrix3d rotation = a.target_from_source.rotation.toRotationMatrix();
  Matrix6d by_a = Matrix6d::Identity(), by_b = Matrix6d::Zero();
  by_a.topRightCorner<3, 3>() = -Hat(rotation * b.target_from_source.translation);
  by_b.topLeftCorner<3, 3>() = by_b.bottomRightCorner<3, 3>() = rotation;
  return {a.target, b.source, a.target_from_source * b.target_from_source,
          by_a * a.covariance * by_a.transpose() + by_b * b.covariance * by_b.transpose()};
}

RelativePose Inverse(const RelativePose& measured) {
  const Rigid3 inverse = measured.target_from_source.Inverse();
  const Eigen::Matrix3d rotation = inverse.rotation.toRotationMatrix();
  // t' = -R^T t, R' = R^T: dt' = -R^T (dt + t x dr), dr' = -R^T dr.
  Matrix6d by = Matrix6d::Zero();
  by.topLeftCorner<3, 3>() = by.bottomRightCorner<3, 3>() = -rotation;
  by.topRightCorner<3, 3>() = -rotation * Hat(measured.target_from_source.translation);
  return {measured.source, measured.target, inverse, by * measured.covariance * by.transpose()};
}

double DisagreementChi2(const RelativePose& a, const RelativePose& b) {
  const Vector6d error = PoseError(a.target_from_source, b.target_from_source);
  return error.dot((a.covariance + b.covariance).ldlt().solve(error));
}

ConsistentSet FindConsistentSet(int poses, const std::vector<RelativePose>& trusted,
                                const std::vector<RelativePose>& closures,
                                const ConsistencyOptions& options) {
  CheckIndices(poses, closures);
  return PairwiseConsistency(poses, trusted, closures, options).Solve(options.most_steps);
}

double MeasureVarianceFactor(int poses, const std::vector<RelativePose>& trusted,
                             const std::vector<RelativePose>& closures) {
  constexpr std::size_t kLeast = 4;
  CheckIndices(poses, closures);
  const TrustedWays ways(poses, trusted);
  std::vector<double> chi2;
  for (const RelativePose& closure : closures) {
    const auto way = ways.From(closure.target)[closure.source];
    if (way) chi2.push_back(DisagreementChi2(way->pose, closure));
  }
  if (chi2.size() < kLeast) return 1.0;
  const auto quartile = chi2.begin() + static_cast<std::ptrdiff_t>(chi2.size() / 4);
  std::nth_element(chi2.begin(), quartile, chi2.end());
  return std::max(1.0, *quartile / ChiSquareQuantile(0.25, 6));
}

std::vector<int> GroupClosures(int poses, const std::vector<RelativePose>& trusted,
                               const std::vector<RelativePose>& closures, int reach,
                               const ConsistencyOptions& options) {
  CheckIndices(poses, closures);
  const TrustedWays ways(poses, trusted);
  const double limit = ChiSquareQuantile(options.confidence, 6) * options.variance_factor;
  DisjointSets sets(closures.size());
  std::vector<std::vector<std::size_t>> of_pose(poses);  // closures that begin or end there
  for (std::size_t p = 0; p < closures.size(); ++p) {
    const Ways from_target = ways.From(closures[p].target, reach);
    const Ways from_source = ways.From(closures[p].source, reach);
    for (int pose = 0; pose < poses; ++pose) {
      if (!from_target[pose]) continue;
      for (const std::size_t q : of_pose[pose]) {
        const auto cycle = CycleOf(closures[p], from_target, from_source, closures[q]);
        if (cycle && cycle->chi2 <= limit) sets.Join(p, q);
      }
    }
    of_pose[closures[p].target].push_back(p);
    of_pose[closures[p].source].push_back(p);
  }
  std::map<std::size_t, int> numbers;
  std::vector<int> groups;
  for (std::size_t p = 0; p < closures.size(); ++p) {
    groups.push_back(
        numbers.try_emplace(sets.Find(p), static_cast<int>(numbers.size())).first->second);
  }
  return groups;
}

}  // namespace planegraph
