#include "planegraph/evaluation/paired_test.h"

#include <gmock/gmock.h>

#include <cmath>
#include <limits>
#include <random>

#include "planegraph/base/error.h"

namespace planegraph {
namespace {

using ::testing::DoubleNear;
using ::testing::ElementsAre;

// Differences 1 .. n, without ties, of which the ranks of the negative ones add up to `sum`.
std::vector<double> WithRankSum(std::size_t n, std::size_t sum) {
  std::vector<double> differences;
  for (std::size_t rank = n; rank >= 1; --rank) {
    const bool negative = rank <= sum;
    if (negative) sum -= rank;
    differences.push_back(static_cast<double>(negative ? -static_cast<double>(rank) : rank));
  }
  return differences;
}

// Critical values of the two-sided test (Wilcoxon and Wilcox 1964, as printed in the textbooks):
// the largest rank sum that is significant, so the next one is not.
TEST(SignedRank, CriticalValuesOfTheTables) {
  struct Row {
    std::size_t n, at_5_percent;
    int at_1_percent;  // -1: none is significant
  };
  const Row table[] = {{6, 0, -1},  {7, 2, -1},   {8, 3, 0},    {9, 5, 1},    {10, 8, 3},
                       {12, 13, 7}, {15, 25, 15}, {20, 52, 37}, {25, 89, 68}, {30, 137, 109}};
  for (const Row& row : table) {
    SCOPED_TRACE(row.n);
    EXPECT_LE(WilcoxonSignedRank(WithRankSum(row.n, row.at_5_percent)).p, 0.05);
    EXPECT_GT(WilcoxonSignedRank(WithRankSum(row.n, row.at_5_percent + 1)).p, 0.05);
    const auto next = static_cast<std::size_t>(row.at_1_percent + 1);
    EXPECT_GT(WilcoxonSignedRank(WithRankSum(row.n, next)).p, 0.01);
    if (row.at_1_percent < 0) continue;
    EXPECT_LE(WilcoxonSignedRank(WithRankSum(row.n, next - 1)).p, 0.01);
  }
}

// Darwin's fifteen pairs of maize plants (Fisher 1935): the classical example; rank sums 96 and 24.
TEST(SignedRank, DarwinsMaize) {
  const SignedRank test =
      WilcoxonSignedRank({49, -67, 8, 16, 6, 23, 28, 41, 14, 29, 56, 24, 75, 60, -48});
  EXPECT_EQ(test.count, 15u);
  EXPECT_EQ(test.rank_sum, 96.0);
  EXPECT_TRUE(test.exact);
  EXPECT_NEAR(test.p, 0.04126, 5e-6);
}

// All signs one by one, with ties.
double ByEnumeration(const std::vector<double>& ranks, double positive) {
  double total = 0.0, count = 0.0;
  for (double rank : ranks) total += rank;
  const double extreme = std::abs(positive - 0.5 * total);
  for (unsigned signs = 0; signs < 1u << ranks.size(); ++signs) {
    double sum = 0.0;
    for (std::size_t k = 0; k < ranks.size(); ++k) sum += signs >> k & 1u ? ranks[k] : 0.0;
    count += std::abs(sum - 0.5 * total) >= extreme - 1e-9 ? 1.0 : 0.0;
  }
  return count / std::ldexp(1.0, static_cast<int>(ranks.size()));
}

TEST(SignedRank, TiesCountByTheirMeanRanks) {
  // |d|: 1 1 2 3 3 3 4, ranks 1.5 1.5 3 5 5 5 7; zeros are left out.
  const SignedRank test = WilcoxonSignedRank({1, -1, 2, 3, 0, 3, -3, 4, 0});
  EXPECT_EQ(test.count, 7u);
  EXPECT_EQ(test.rank_sum, 21.5);
  EXPECT_NEAR(test.p, ByEnumeration({1.5, 1.5, 3, 5, 5, 5, 7}, 21.5), 1e-12);
}

TEST(SignedRank, OppositeDifferencesAreAsUnlikely) {
  std::mt19937 random(1);
  std::normal_distribution<double> normal(0.4, 1.0);
  for (std::size_t n : {1u, 5u, 30u, 200u, 201u, 300u}) {
    std::vector<double> differences, opposite;
    for (std::size_t k = 0; k < n; ++k) {
      differences.push_back(normal(random));
      opposite.push_back(-differences.back());
    }
    const SignedRank a = WilcoxonSignedRank(differences), b = WilcoxonSignedRank(opposite);
    EXPECT_NEAR(a.p, b.p, 1e-12);
    EXPECT_EQ(a.rank_sum + b.rank_sum, 0.5 * static_cast<double>(n * (n + 1)));
    EXPECT_EQ(a.exact, n <= kMostExact);
  }
}

// The exact p-value and the normal one agree where one gives way to the other.
TEST(SignedRank, TheApproximationMeetsTheExactValues) {
  for (std::size_t sum : {8000u, 8700u, 9400u, 10000u}) {
    const double exact = WilcoxonSignedRank(WithRankSum(200, sum)).p;
    const double mean = 200.0 * 201.0 / 4.0, deviation = std::sqrt(mean * 401.0 / 6.0);
    const double z = (std::abs(static_cast<double>(sum) - mean) - 0.5) / deviation;
    EXPECT_NEAR(exact, std::erfc(z / std::sqrt(2.0)), 0.02 * exact + 1e-4);
  }
}

TEST(SignedRank, OfNothingIsOne) {
  EXPECT_EQ(WilcoxonSignedRank({}).p, 1.0);
  EXPECT_EQ(WilcoxonSignedRank({0, 0}).p, 1.0);
  EXPECT_EQ(WilcoxonSignedRank({2}).p, 1.0);
  EXPECT_NEAR(WilcoxonSignedRank({1, 2, 3, 4, 5}).p, 2.0 / 32.0, 1e-15);
  EXPECT_THROW(WilcoxonSignedRank({std::numeric_limits<double>::quiet_NaN()}), UsageError);
}

// Under the null hypothesis a p-value of at most 5 % comes in at most 5 % of all cases.
TEST(SignedRank, KeepsItsLevel) {
  std::mt19937 random(2);
  std::uniform_real_distribution<double> uniform(-1.0, 1.0);
  int rejected = 0;
  const int trials = 4000;
  for (int trial = 0; trial < trials; ++trial) {
    std::vector<double> differences(12);
    for (double& d : differences) d = uniform(random);
    rejected += WilcoxonSignedRank(differences).p <= 0.05 ? 1 : 0;
  }
  EXPECT_LT(rejected, 0.06 * trials);
  EXPECT_GT(rejected, 0.03 * trials);  // T <= 13 of 12 has p = 0.0425
}

// Holm's own procedure: 0.01 x 4, 0.02 x 3, 0.03 x 2, 0.04 x 1, never below the one before.
TEST(Holm, AdjustsStepByStep) {
  EXPECT_THAT(HolmAdjusted({0.04, 0.01, 0.03, 0.02}),
              ElementsAre(DoubleNear(0.06, 1e-15), DoubleNear(0.04, 1e-15), DoubleNear(0.06, 1e-15),
                          DoubleNear(0.06, 1e-15)));
  EXPECT_THAT(HolmAdjusted({0.5, 0.9}), ElementsAre(1.0, 1.0));
  EXPECT_THAT(HolmAdjusted({0.02}), ElementsAre(0.02));
  EXPECT_TRUE(HolmAdjusted({}).empty());
}

}  // namespace
}  // namespace planegraph
