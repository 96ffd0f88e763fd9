#include "planegraph/evaluation/paired_test.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "planegraph/base/error.h"

namespace planegraph {
namespace {

// The differences that are not zero, by magnitude.
std::vector<double> NonZeroByMagnitude(const std::vector<double>& differences) {
  std::vector<double> sorted;
  for (double d : differences) {
    if (!std::isfinite(d)) throw UsageError("paired differences must be finite");
    if (d != 0.0) sorted.push_back(d);
  }
  std::sort(sorted.begin(), sorted.end(),
            [](double a, double b) { return std::abs(a) < std::abs(b); });
  return sorted;
}

// Twice the ranks, which are whole numbers: equal magnitudes share the mean of their ranks.
std::vector<std::size_t> DoubledRanks(const std::vector<double>& sorted) {
  std::vector<std::size_t> ranks(sorted.size());
  for (std::size_t first = 0; first < sorted.size();) {
    std::size_t last = first;
    while (last < sorted.size() && std::abs(sorted[last]) == std::abs(sorted[first])) ++last;
    std::fill(ranks.begin() + static_cast<std::ptrdiff_t>(first),
              ranks.begin() + static_cast<std::ptrdiff_t>(last), first + 1 + last);
    first = last;
  }
  return ranks;
}

// Probability of every sum of the ranks whose sign is positive, all signs being equally likely.
std::vector<double> SumProbabilities(const std::vector<std::size_t>& ranks) {
  std::vector<double> probability(std::accumulate(ranks.begin(), ranks.end(), std::size_t{1}));
  probability[0] = 1.0;
  std::size_t reached = 0;
  for (std::size_t rank : ranks) {
    reached += rank;
    for (std::size_t sum = reached + 1; sum-- > 0;) {
      probability[sum] = 0.5 * (probability[sum] + (sum >= rank ? probability[sum - rank] : 0.0));
    }
  }
  return probability;
}

double ExactP(const std::vector<std::size_t>& ranks, std::size_t positive) {
  const std::vector<double> probability = SumProbabilities(ranks);
  const std::size_t opposite = probability.size() - 1 - positive;
  double tail = 0.0;  // the distribution is symmetric
  for (std::size_t sum = 0; sum <= std::min(positive, opposite); ++sum) tail += probability[sum];
  return std::min(1.0, 2.0 * tail);
}

double NormalP(const std::vector<std::size_t>& ranks, std::size_t positive) {
  double mean = 0.0, variance = 0.0;
  for (std::size_t doubled : ranks) {
    const double rank = 0.5 * static_cast<double>(doubled);
    mean += 0.5 * rank;
    variance += 0.25 * rank * rank;
  }
  const double excess = std::abs(0.5 * static_cast<double>(positive) - mean) - 0.5;
  return std::erfc(std::max(0.0, excess) / std::sqrt(2.0 * variance));
}

}  // namespace

SignedRank WilcoxonSignedRank(const std::vector<double>& differences) {
  const std::vector<double> sorted = NonZeroByMagnitude(differences);
  const std::vector<std::size_t> ranks = DoubledRanks(sorted);
  std::size_t positive = 0;
  for (std::size_t i = 0; i < sorted.size(); ++i) positive += sorted[i] > 0.0 ? ranks[i] : 0;
  SignedRank result;
  result.count = sorted.size();
  result.rank_sum = 0.5 * static_cast<double>(positive);
  result.exact = sorted.size() <= kMostExact;
  if (!sorted.empty()) result.p = result.exact ? ExactP(ranks, positive) : NormalP(ranks, positive);
  return result;
}

std::vector<double> HolmAdjusted(const std::vector<double>& p_values) {
  std::vector<std::size_t> order(p_values.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::stable_sort(order.begin(), order.end(),
                   [&](std::size_t a, std::size_t b) { return p_values[a] < p_values[b]; });
  std::vector<double> adjusted(p_values.size());
  double largest = 0.0;
  for (std::size_t k = 0; k < order.size(); ++k) {
    const double factor = static_cast<double>(order.size() - k);
    largest = std::max(largest, std::min(1.0, factor * p_values[order[k]]));
    adjusted[order[k]] = largest;
  }
  return adjusted;
}

}  // namespace planegraph
