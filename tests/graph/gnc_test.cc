#include "planegraph/graph/gnc.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <stdexcept>

namespace planegraph {
namespace {

// The surrogate of truncated least squares that the weights belong to (Yang 2020, equation 5).
double TruncatedSurrogate(double mu, double c2, double s) {
  if (s <= mu / (mu + 1.0) * c2) return s;
  if (s >= (mu + 1.0) / mu * c2) return c2;
  return 2.0 * std::sqrt(c2 * s * mu * (mu + 1.0)) - mu * (c2 + s);
}

double GemanMcClureSurrogate(double mu, double c2, double s) { return mu * c2 * s / (mu * c2 + s); }

TEST(GncSchedule, WeightsAreTheDerivativesOfTheSurrogates) {
  const double scale = 2.8, c2 = scale * scale;
  for (const GncKernel kernel : {GncKernel::kTruncated, GncKernel::kGemanMcClure}) {
    GncSchedule schedule(kernel, scale);
    schedule.Start({1e4});
    const auto surrogate =
        kernel == GncKernel::kTruncated ? TruncatedSurrogate : GemanMcClureSurrogate;
    for (int step = 0; step < 40 && !schedule.Finished(); ++step) {
      for (double s = 0.01; s < 3e4; s *= 1.37) {
        const double h = 1e-5 * s, mu = schedule.mu();
        const double slope = (surrogate(mu, c2, s + h) - surrogate(mu, c2, s - h)) / (2.0 * h);
        EXPECT_NEAR(schedule.Weight(s), slope, 1e-5) << s << " at mu " << mu;
      }
      schedule.Advance({1e4, 0.5, c2});
    }
  }
}

TEST(GncSchedule, StartsConvexAndEndsAtTheRobustCost) {
  for (const GncKernel kernel : {GncKernel::kTruncated, GncKernel::kGemanMcClure}) {
    GncSchedule schedule(kernel, 2.0);
    schedule.Start({1.0, 400.0});
    EXPECT_GT(schedule.Weight(400.0), 0.0);
    int steps = 0;
    while (!schedule.Finished()) {
      schedule.Advance({1.0, 4.0, 400.0});  // 4 = c^2 never gets a binary weight
      ASSERT_LT(++steps, 200);
    }
    for (const double s : {0.0, 1.0, 3.9, 4.1, 400.0}) {
      EXPECT_NEAR(schedule.Weight(s), schedule.FinalWeight(s), 1e-5);
    }
  }
}

TEST(GncSchedule, InliersAloneNeedNoSchedule) {
  GncSchedule schedule(GncKernel::kTruncated, 3.0);
  schedule.Start({0.0, 1.0, 8.9});
  EXPECT_TRUE(schedule.Finished());
  EXPECT_EQ(schedule.Weight(8.9), 1.0);
  schedule.Start({});
  EXPECT_TRUE(schedule.Finished());
}

// A mean with 70 % of wild values, from no guess.
TEST(GncSchedule, FindsTheMeanOfAMinority) {
  std::mt19937_64 rng(5);
  std::normal_distribution<double> normal;
  std::uniform_real_distribution<double> wild(-100.0, 100.0);
  for (const GncKernel kernel : {GncKernel::kTruncated, GncKernel::kGemanMcClure}) {
    std::vector<double> values;
    for (int k = 0; k < 200; ++k) values.push_back(k < 60 ? 20.0 + normal(rng) : wild(rng));
    std::vector<double> weights(values.size(), 1.0), chi2(values.size());
    double mean = 0.0;
    const auto solve = [&] {
      double sum = 0.0, total = 0.0;
      for (std::size_t k = 0; k < values.size(); ++k) {
        sum += weights[k] * values[k], total += weights[k];
      }
      mean = sum / total;
      for (std::size_t k = 0; k < values.size(); ++k) chi2[k] = std::pow(values[k] - mean, 2);
    };
    GncSchedule schedule(kernel, 3.0);
    solve();
    schedule.Start(chi2);
    while (!schedule.Finished()) {
      for (std::size_t k = 0; k < values.size(); ++k) weights[k] = schedule.Weight(chi2[k]);
      solve();
      schedule.Advance(chi2);
    }
    EXPECT_NEAR(mean, 20.0, 0.8);
  }
}

TEST(GncSchedule, RefusesImpossibleParameters) {
  EXPECT_THROW(GncSchedule(GncKernel::kTruncated, 0.0), std::invalid_argument);
  EXPECT_THROW(GncSchedule(GncKernel::kTruncated, 1.0, 1.0), std::invalid_argument);
}

}  // namespace
}  // namespace planegraph
