#include "planegraph/evaluation/median_interval.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

namespace planegraph {
namespace {

double MedianOf(std::vector<double> values) {
  std::sort(values.begin(), values.end());
  const std::size_t half = values.size() / 2;
  return values.size() % 2 == 1 ? values[half] : 0.5 * (values[half - 1] + values[half]);
}

// The medians of all n^n resamples, sorted.
std::vector<double> AllMedians(const std::vector<double>& values) {
  const std::size_t n = values.size();
  const auto count = static_cast<std::size_t>(std::llround(std::pow(n, n)));
  std::vector<double> medians;
  for (std::size_t code = 0; code < count; ++code) {
    std::vector<double> sample;
    for (std::size_t k = 0, rest = code; k < n; ++k, rest /= n) sample.push_back(values[rest % n]);
    medians.push_back(MedianOf(sample));
  }
  std::sort(medians.begin(), medians.end());
  return medians;
}

// The least value that at least this part of the sorted values does not exceed.
double QuantileOf(const std::vector<double>& sorted, double part) {
  const double rank = std::ceil(part * static_cast<double>(sorted.size()) - 1e-6);
  return sorted[static_cast<std::size_t>(std::max(1.0, rank)) - 1];
}

TEST(BootstrapMedian, IsThatOfAllResamples) {
  for (const std::vector<double>& values : {std::vector<double>{3.0, 1.0, 4.0, 1.5, 9.0, 2.6},
                                            {0.3, 0.1, 0.7, 0.2, 0.9, 0.45, 0.5},
                                            {1.0, 1.0, 2.0, 2.0, 2.0, 7.0}}) {
    const std::vector<double> medians = AllMedians(values);
    for (double level : {0.5, 0.8, 0.9, 0.95}) {
      const auto interval = BootstrapMedianInterval(values, level);
      ASSERT_TRUE(interval);
      EXPECT_NEAR(interval->low, QuantileOf(medians, 0.5 - 0.5 * level), 1e-12) << level;
      EXPECT_NEAR(interval->high, QuantileOf(medians, 0.5 + 0.5 * level), 1e-12) << level;
    }
  }
}

TEST(BootstrapMedian, NeedsEnoughValuesForItsLevel) {
  EXPECT_EQ(LeastForMedianInterval(0.95), 6u);  // 1 - 2^-5 = 0.969
  EXPECT_EQ(LeastForMedianInterval(0.9), 5u);
  EXPECT_EQ(LeastForMedianInterval(0.5), 2u);
  EXPECT_FALSE(BootstrapMedianInterval({1, 2, 3, 4, 5}, 0.95));
  EXPECT_FALSE(BootstrapMedianInterval({}, 0.95));
  EXPECT_TRUE(BootstrapMedianInterval({1, 2, 3, 4, 5, 6}, 0.95));
}

TEST(BootstrapMedian, FollowsShiftScaleAndSign) {
  std::mt19937 random(3);
  std::normal_distribution<double> normal;
  for (std::size_t n : {6u, 7u, 20u, 31u}) {
    std::vector<double> values(n), mapped(n);
    for (std::size_t k = 0; k < n; ++k) {
      values[k] = normal(random);
      mapped[n - 1 - k] = 5.0 - 2.0 * values[k];
    }
    const auto a = BootstrapMedianInterval(values, 0.95), b = BootstrapMedianInterval(mapped, 0.95);
    ASSERT_TRUE(a && b);
    EXPECT_NEAR(b->low, 5.0 - 2.0 * a->high, 1e-12);
    EXPECT_NEAR(b->high, 5.0 - 2.0 * a->low, 1e-12);
  }
}

// Of many values: median +- 1.96 sqrt(pi/2) / sqrt(n), the sample median's standard error.
TEST(BootstrapMedian, IsAsWideAsTheoryExpects) {
  std::mt19937 random(4);
  std::normal_distribution<double> normal;
  for (std::size_t n : {2000u, 2001u}) {
    std::vector<double> values(n);
    for (double& v : values) v = normal(random);
    const auto interval = BootstrapMedianInterval(values, 0.95);
    ASSERT_TRUE(interval);
    const double wanted = 2.0 * 1.96 * std::sqrt(std::acos(0.0) / static_cast<double>(n));
    EXPECT_NEAR(interval->high - interval->low, wanted, 0.25 * wanted);
  }
}

TEST(BootstrapMedian, HoldsTheMedianAboutAsOftenAsItSays) {
  std::mt19937 random(5);
  std::exponential_distribution<double> skewed;
  const double truth = std::log(2.0);
  for (std::size_t n : {15u, 16u}) {
    int held = 0;
    const int trials = 1000;
    for (int trial = 0; trial < trials; ++trial) {
      std::vector<double> values(n);
      for (double& v : values) v = skewed(random);
      const auto interval = BootstrapMedianInterval(values, 0.95);
      held += interval && interval->low <= truth && truth <= interval->high ? 1 : 0;
    }
    EXPECT_GT(held, 0.91 * trials) << n;
    EXPECT_LT(held, 0.99 * trials) << n;
  }
}

}  // namespace
}  // namespace planegraph
