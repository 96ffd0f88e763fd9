#include "planegraph/evaluation/median_interval.h"

#include <algorithm>
#include <cmath>

namespace planegraph {
namespace {

// Less than this of all resamples decides on nothing.
constexpr double kNegligible = 1e-13;

double LogBinomial(std::size_t n, std::size_t k) {
  const auto log_factorial = [](std::size_t m) { return std::lgamma(static_cast<double>(m) + 1); };
  return log_factorial(n) - log_factorial(k) - log_factorial(n - k);
}

double Ratio(std::size_t a, std::size_t b) {
  return static_cast<double>(a) / static_cast<double>(b);
}

// P(at least `least` of n draws are among `good` of n values).
double AtLeast(std::size_t least, std::size_t good, std::size_t n) {
  if (good == 0) return 0.0;
  if (good == n) return 1.0;
  double sum = 0.0;
  for (std::size_t k = least; k <= n; ++k) {
    sum += std::exp(LogBinomial(n, k) + static_cast<double>(k) * std::log(Ratio(good, n)) +
                    static_cast<double>(n - k) * std::log1p(-Ratio(good, n)));
  }
  return sum;
}

struct Atom {
  double value = 0.0, probability = 0.0;
};

// P(the order statistic `rank` of a resample is the i-th value), i = 0 the least.
std::vector<double> OrderStatistic(std::size_t rank, std::size_t n) {
  std::vector<double> probability(n);
  double below = 0.0;
  for (std::size_t i = 0; i < n; ++i) {
    const double up_to = AtLeast(rank, i + 1, n);
    probability[i] = std::max(0.0, up_to - below);
    below = up_to;
  }
  return probability;
}

std::vector<Atom> OddAtoms(const std::vector<double>& sorted) {
  const std::vector<double> p = OrderStatistic((sorted.size() + 1) / 2, sorted.size());
  std::vector<Atom> atoms;
  for (std::size_t i = 0; i < sorted.size(); ++i) atoms.push_back({sorted[i], p[i]});
  return atoms;
}

// log((i/n)^m - ((i-1)/n)^m): all of m draws among the i least, not all among the i-1 least.
double LogReaches(std::size_t i, std::size_t m, std::size_t n) {
  const double power = static_cast<double>(m);
  const double whole = power * std::log(Ratio(i, n));
  return i == 1 ? whole : whole + std::log1p(-std::pow(Ratio(i - 1, i), power));
}

// The middle two of 2m draws are the values i < j: m draws reach up to i, m down to j. What the
// i-th value as the lower one has beyond that, it has as both.
std::vector<Atom> EvenAtoms(const std::vector<double>& sorted) {
  const std::size_t n = sorted.size(), m = n / 2;
  const std::vector<double> lower = OrderStatistic(m, n);
  const double log_ways = LogBinomial(n, m);
  std::vector<Atom> atoms;
  for (std::size_t i = 0; i < n; ++i) {
    double rest = lower[i];
    for (std::size_t j = i + 1; j < n && rest > kNegligible; ++j) {
      const double p = std::exp(log_ways + LogReaches(i + 1, m, n) + LogReaches(n - j, m, n));
      if (p > kNegligible) atoms.push_back({0.5 * (sorted[i] + sorted[j]), p});
      rest -= p;
    }
    if (rest > kNegligible) atoms.push_back({sorted[i], rest});
  }
  std::sort(atoms.begin(), atoms.end(), [](const Atom& a, const Atom& b) {
    return a.value != b.value ? a.value < b.value : a.probability < b.probability;
  });
  return atoms;
}

double Quantile(const std::vector<Atom>& atoms, double wanted) {
  double sum = 0.0;
  for (const Atom& atom : atoms) {
    sum += atom.probability;
    if (sum >= wanted - 1e-9) return atom.value;
  }
  return atoms.back().value;
}

}  // namespace

std::size_t LeastForMedianInterval(double level) {
  std::size_t count = 2;
  while (1.0 - std::pow(0.5, static_cast<double>(count - 1)) < level && count < 1000) ++count;
  return count;
}

std::optional<Interval> BootstrapMedianInterval(std::vector<double> values, double level) {
  if (values.size() < LeastForMedianInterval(level)) return {};
  std::sort(values.begin(), values.end());
  const std::vector<Atom> atoms = values.size() % 2 == 1 ? OddAtoms(values) : EvenAtoms(values);
  return Interval{Quantile(atoms, 0.5 - 0.5 * level), Quantile(atoms, 0.5 + 0.5 * level)};
}

}  // namespace planegraph
