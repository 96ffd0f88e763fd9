#pragma once

#include <optional>
#include <vector>

#include "planegraph/graph/graph.h"

namespace planegraph {

/// A measured relative pose, say a registration. `covariance`: order x y z rx ry rz of the
/// decoupled left perturbation in the target's axes, metres and radians; a direction that was not
/// observed has a large variance, not an infinite one.
struct RelativePose {
  int target = 0, source = 0;  ///< indices of poses
  Rigid3 target_from_source;
  Matrix6d covariance = Matrix6d::Identity();
};

/// a_from_c of a_from_b and b_from_c, whose errors are independent, to first order.
RelativePose Compose(const RelativePose& a_from_b, const RelativePose& b_from_c);
RelativePose Inverse(const RelativePose& target_from_source);

/// Squared Mahalanobis distance of two measurements of one relative pose with independent errors:
/// chi-square with six degrees of freedom where both covariances are honest.
double DisagreementChi2(const RelativePose& a, const RelativePose& b);

struct ConsistencyOptions {
  /// Two measurements agree up to this quantile of chi-square: beyond all chance, as not every
  /// registration's covariance is honest.
  double confidence = 1.0 - 1e-6;
  /// All covariances are taken this many times as large (MeasureVarianceFactor).
  double variance_factor = 1.0;
  /// Steps of the search for the largest set; the best found so far where they run out.
  int most_steps = 200000;
};

/// Why a measurement is not in the set, and how far it is from it.
struct Inconsistency {
  std::size_t measurement = 0;
  bool with_way = false;             ///< it contradicts the trusted way between its own ends
  std::vector<std::size_t> against;  ///< measurements of the set that it contradicts
  double chi2 = 0.0;                 ///< the largest, the factor taken off
  double limit = 0.0;                ///< what it may be
};

struct ConsistentSet {
  std::vector<bool> consistent;        ///< of each measurement
  std::vector<Inconsistency> refused;  ///< those that are not, in their order
};

/// The largest set of loop closures of which any two agree, after pairwise consistency maximization
/// (Mangelson, Dominic, Eustice, Vasudevan: Pairwise consistent measurement set maximization for
/// robust multi-robot map merging, ICRA 2018). Two closures agree where the cycle of both and of
/// the trusted ways between their ends closes, as far as all covariances say; the largest set is a
/// maximum clique of the graph of agreement (branch and bound with colours, Tomita and Seki 2003).
/// A closure both of whose ends one trusted way joins has to agree with this way too. Closures that
/// no trusted way joins to others contradict nothing.
///
/// `trusted`: odometry or registrations of consecutive scans; a spanning forest of the most certain
/// ones is used. Ways that closures share are taken for independent. The set does not depend on
/// the measurements' directions (target, source), and on their order only where two sets are
/// equally large. Throws std::invalid_argument for indices out of range.
ConsistentSet FindConsistentSet(int poses, const std::vector<RelativePose>& trusted,
                                const std::vector<RelativePose>& closures,
                                const ConsistencyOptions& options = {});

/// How many times larger than claimed the variances are, at least 1, by the closures against the
/// trusted ways between their own ends: from the lower quartile, so that up to three quarters of
/// the closures may be wrong. 1 with fewer than four that can be compared.
double MeasureVarianceFactor(int poses, const std::vector<RelativePose>& trusted,
                             const std::vector<RelativePose>& closures);

/// Closures that are right or wrong together: of the same two stretches of the way (ends at most
/// `reach` trusted steps apart, at both ends) and in agreement with each other. One number for each
/// closure, from 0 in the order of their first members.
std::vector<int> GroupClosures(int poses, const std::vector<RelativePose>& trusted,
                               const std::vector<RelativePose>& closures, int reach,
                               const ConsistencyOptions& options = {});

}  // namespace planegraph
