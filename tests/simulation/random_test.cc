#include "planegraph/simulation/random.h"

#include <gtest/gtest.h>

#include <cmath>

namespace planegraph {
namespace {

constexpr int kDraws = 200000;

TEST(RandomTest, UniformHasTheMomentsOfTheUniformDistribution) {
  Random random(7);
  double sum = 0.0, squares = 0.0;
  for (int i = 0; i < kDraws; ++i) {
    const double value = random.Uniform(-1.0, 3.0);
    ASSERT_GE(value, -1.0);
    ASSERT_LT(value, 3.0);
    sum += value;
    squares += (value - 1.0) * (value - 1.0);
  }
  // Variance (b - a)^2 / 12; five standard errors of the mean and of the variance.
  EXPECT_NEAR(sum / kDraws, 1.0, 5.0 * std::sqrt(16.0 / 12.0 / kDraws));
  EXPECT_NEAR(squares / kDraws, 16.0 / 12.0, 5.0 * 1.2 / std::sqrt(kDraws));
}

TEST(RandomTest, NormalHasTheMomentsOfTheNormalDistribution) {
  Random random(8);
  double moments[5] = {};
  for (int i = 0; i < kDraws; ++i) {
    const double value = random.Normal();
    for (int k = 1; k <= 4; ++k) moments[k] += std::pow(value, k) / kDraws;
  }
  // Standard errors from the moments of order 2k: 1, 2, 15 and 105 - 9.
  const double error = 5.0 / std::sqrt(kDraws);
  EXPECT_NEAR(moments[1], 0.0, error);
  EXPECT_NEAR(moments[2], 1.0, error * std::sqrt(2.0));
  EXPECT_NEAR(moments[3], 0.0, error * std::sqrt(15.0));
  EXPECT_NEAR(moments[4], 3.0, error * std::sqrt(96.0));
}

TEST(RandomTest, StreamsAndSeedsAreIndependentAndRepeatable) {
  EXPECT_EQ(Random(1, 2).Uniform(), Random(1, 2).Uniform());
  EXPECT_NE(Random(1, 2).Uniform(), Random(1, 3).Uniform());
  EXPECT_NE(Random(1, 2).Uniform(), Random(2, 2).Uniform());
  EXPECT_NE(Random(1, 2).Uniform(), Random(2, 1).Uniform());
}

TEST(RandomTest, IndexCoversItsRange) {
  Random random(3);
  int counts[3] = {};
  for (int i = 0; i < 3000; ++i) ++counts[random.Index(3)];
  for (const int count : counts) EXPECT_NEAR(count, 1000, 5 * std::sqrt(3000 * 2.0 / 9.0));
}

}  // namespace
}  // namespace planegraph
