#pragma once

#include <cstddef>
#include <vector>

namespace planegraph {

/// Wilcoxon's signed-rank test of paired differences.
struct SignedRank {
  std::size_t count = 0;  ///< differences that are not zero
  double rank_sum = 0.0;  ///< of the positive ones; ties share the mean of their ranks
  double p = 1.0;         ///< two-sided
  bool exact = true;      ///< from all 2^count signs; else by the normal distribution
};

/// Tests whether differences are symmetric about 0 (Wilcoxon 1945). Zeros are left out, as he does.
/// Up to kMostExact differences the p-value is that of all assignments of signs to the very ranks,
/// ties among them included; beyond that the normal approximation with the ties' variance and a
/// continuity correction. Without a difference p is 1. Throws UsageError for values that are not
/// finite.
SignedRank WilcoxonSignedRank(const std::vector<double>& differences);
inline constexpr std::size_t kMostExact = 200;

/// The p-values of one family of tests, adjusted so that the chance of any false rejection stays
/// below the level that they are compared with (Holm 1979). In the order given.
std::vector<double> HolmAdjusted(const std::vector<double>& p_values);

}  // namespace planegraph
