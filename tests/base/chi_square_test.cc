#include "planegraph/base/chi_square.h"

#include <gtest/gtest.h>

#include <cmath>
#include <stdexcept>

namespace planegraph {
namespace {

struct Case {
  double probability;
  int degrees;
  double quantile;
};

// Abramowitz and Stegun, table 26.8.
TEST(ChiSquareQuantile, IsThatOfTheTables) {
  for (const Case& c : {Case{0.99, 1, 6.63490},
                        {0.99, 2, 9.21034},
                        {0.99, 3, 11.3449},
                        {0.99, 6, 16.8119},
                        {0.99, 15, 30.5779},
                        {0.95, 3, 7.81473},
                        {0.5, 3, 2.36597},
                        {0.005, 10, 2.15585},
                        {0.99, 100, 135.807}}) {
    EXPECT_NEAR(ChiSquareQuantile(c.probability, c.degrees) / c.quantile, 1.0, 5e-6) << c.degrees;
  }
}

TEST(ChiSquareQuantile, HasTheTailThatIsAskedFor) {
  for (int degrees = 1; degrees <= 300; degrees += 13) {
    for (const double probability : {1e-6, 0.1, 0.5, 0.9, 0.999999}) {
      const double tail = ChiSquareTail(ChiSquareQuantile(probability, degrees), degrees);
      EXPECT_NEAR(tail, 1.0 - probability, 1e-10);
    }
  }
  // Thousands of degrees: the normal distribution of the square root (Fisher).
  EXPECT_NEAR(std::sqrt(2.0 * ChiSquareQuantile(0.5, 5000)), std::sqrt(2.0 * 5000 - 1.0), 0.01);
  // Two degrees: the exponential distribution.
  EXPECT_NEAR(ChiSquareQuantile(0.99, 2), -2.0 * std::log(0.01), 1e-10);
}

TEST(ChiSquareQuantile, RefusesWhatIsNone) {
  EXPECT_THROW(ChiSquareQuantile(1.0, 3), std::invalid_argument);
  EXPECT_THROW(ChiSquareQuantile(0.0, 3), std::invalid_argument);
  EXPECT_THROW(ChiSquareQuantile(0.5, 0), std::invalid_argument);
}

}  // namespace
}  // namespace planegraph
