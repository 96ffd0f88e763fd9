#include "planegraph/evaluation/interval.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace planegraph {
namespace {

// P(|T| <= t), the finite sums for whole degrees (Abramowitz and Stegun 26.7.3 and 26.7.4).
double StudentCentral(double t, std::size_t degrees) {
  const double angle = std::atan(t / std::sqrt(static_cast<double>(degrees)));
  const double sine = std::sin(angle), cosine = std::cos(angle);
  const bool odd = degrees % 2 == 1;
  double term = odd ? cosine : 1.0, sum = 0.0;
  for (std::size_t k = odd ? 1 : 0; k + 2 <= degrees; k += 2) {
    sum += term;
    term *= cosine * cosine * static_cast<double>(k + 1) / static_cast<double>(k + 2);
  }
  if (!odd) return sine * sum;
  return 2.0 / std::numbers::pi * (angle + sine * sum);
}

double StandardError(const std::vector<double>& without) {
  const double count = static_cast<double>(without.size());
  double mean = 0.0, squares = 0.0;
  for (double value : without) mean += value / count;
  for (double value : without) squares += (value - mean) * (value - mean);
  return std::sqrt((count - 1.0) / count * squares);
}

double HalfWidthFactor(std::size_t blocks, double level) {
  return StudentQuantile(0.5 + 0.5 * level, blocks - 1);
}

}  // namespace

double StudentQuantile(double probability, std::size_t degrees) {
  if (probability < 0.5) return -StudentQuantile(1.0 - probability, degrees);
  const double wanted = 2.0 * probability - 1.0;
  double low = 0.0, high = 1.0;
  while (StudentCentral(high, degrees) < wanted && high < 1e12) high *= 2.0;
  for (int k = 0; k < 200 && high - low > 1e-13 * high; ++k) {
    const double middle = 0.5 * (low + high);
    (StudentCentral(middle, degrees) < wanted ? low : high) = middle;
  }
  return 0.5 * (low + high);
}

std::vector<std::pair<std::size_t, std::size_t>> ConsecutiveBlocks(std::size_t count,
                                                                   std::size_t blocks) {
  const std::size_t used = std::min(count, blocks);
  std::vector<std::pair<std::size_t, std::size_t>> result;
  for (std::size_t b = 0; b < used; ++b) {
    result.emplace_back(b * count / used, (b + 1) * count / used);
  }
  return result;
}

std::optional<Interval> JackknifeInterval(double estimate, const std::vector<double>& without,
                                          double level) {
  if (without.size() < kLeastBlocks) return {};
  const double half = HalfWidthFactor(without.size(), level) * StandardError(without);
  return Interval{estimate - half, estimate + half};
}

std::optional<Interval> JackknifeMagnitude(double estimate, const std::vector<double>& without,
                                           double level) {
  if (without.size() < kLeastBlocks) return {};
  const auto is_zero = [](double value) { return !(value > 0.0); };
  // Without logarithms: an estimate of nothing but zeros, or all of it in one block.
  if (is_zero(estimate) || std::any_of(without.begin(), without.end(), is_zero)) {
    const Interval plain = *JackknifeInterval(estimate, without, level);
    return Interval{std::max(0.0, plain.low), plain.high};
  }
  std::vector<double> logarithms;
  for (double value : without) logarithms.push_back(std::log(value));
  const double half = HalfWidthFactor(without.size(), level) * StandardError(logarithms);
  return Interval{estimate * std::exp(-half), estimate * std::exp(half)};
}

std::optional<Interval> MeanInterval(const std::vector<BlockSum>& blocks, double level) {
  BlockSum all;
  std::size_t filled = 0;
  for (const BlockSum& block : blocks) {
    all.sum += block.sum;
    all.count += block.count;
    filled += block.count > 0.0 ? 1 : 0;
  }
  if (filled < kLeastBlocks) return {};
  const double mean = all.sum / all.count;
  double squares = 0.0;
  for (const BlockSum& block : blocks) {
    const double excess = block.sum - block.count * mean;
    squares += excess * excess;
  }
  const double correction = static_cast<double>(filled) / static_cast<double>(filled - 1);
  const double half = HalfWidthFactor(filled, level) * std::sqrt(correction * squares) / all.count;
  return Interval{mean - half, mean + half};
}

}  // namespace planegraph
