#include "planegraph/evaluation/interval.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "planegraph/evaluation/trajectory_error.h"
#include "planegraph/geometry/rotation.h"

namespace planegraph {
namespace {

// Values of printed tables (Abramowitz and Stegun, table 26.10).
TEST(Student, QuantilesOfTheTables) {
  const std::pair<std::size_t, double> table[] = {{1, 12.706}, {2, 4.303},  {3, 3.182},
                                                  {6, 2.447},  {19, 2.093}, {120, 1.980}};
  for (const auto& [degrees, value] : table) {
    EXPECT_NEAR(StudentQuantile(0.975, degrees), value, 6e-4) << degrees;
    EXPECT_NEAR(StudentQuantile(0.025, degrees), -value, 6e-4) << degrees;
  }
  EXPECT_NEAR(StudentQuantile(0.5, 4), 0.0, 1e-12);
  EXPECT_NEAR(StudentQuantile(0.995, 10), 3.169, 6e-4);
}

TEST(Blocks, CoverEverythingOnce) {
  for (std::size_t count : {0u, 1u, 7u, 20u, 21u, 1000u}) {
    const auto blocks = ConsecutiveBlocks(count, 20);
    EXPECT_EQ(blocks.size(), std::min<std::size_t>(count, 20));
    std::size_t next = 0;
    for (const auto& [first, last] : blocks) {
      EXPECT_EQ(first, next);
      EXPECT_GT(last, first);
      next = last;
    }
    EXPECT_EQ(next, count);
  }
}

// Of a mean, the jackknife without single values is the textbook's interval.
TEST(Jackknife, OfAMeanIsStudents) {
  const std::vector<double> values{1.0, 4.0, 2.0, 8.0, 5.0, 7.0};
  double sum = 0.0, squares = 0.0;
  for (double v : values) sum += v;
  for (double v : values) squares += (v - sum / 6.0) * (v - sum / 6.0);
  const double half = StudentQuantile(0.975, 5) * std::sqrt(squares / 5.0 / 6.0);
  std::vector<double> without;
  std::vector<BlockSum> blocks;
  for (double v : values) {
    without.push_back((sum - v) / 5.0);
    blocks.push_back({v, 1.0});
  }
  for (const auto& interval :
       {JackknifeInterval(sum / 6.0, without, 0.95), MeanInterval(blocks, 0.95)}) {
    ASSERT_TRUE(interval);
    EXPECT_NEAR(interval->low, sum / 6.0 - half, 1e-12);
    EXPECT_NEAR(interval->high, sum / 6.0 + half, 1e-12);
  }
  const auto magnitude = JackknifeMagnitude(sum / 6.0, without, 0.95);
  ASSERT_TRUE(magnitude);
  EXPECT_GT(magnitude->low, 0.0);
  EXPECT_FALSE(JackknifeInterval(1.0, {1.0, 2.0, 3.0}, 0.95));
  EXPECT_FALSE(MeanInterval({{1.0, 1.0}, {2.0, 1.0}, {3.0, 1.0}, {0.0, 0.0}}, 0.95));
}

TEST(Jackknife, OfZerosIsZero) {
  const auto interval = JackknifeMagnitude(0.0, std::vector<double>(10, 0.0), 0.95);
  ASSERT_TRUE(interval);
  EXPECT_EQ(interval->low, 0.0);
  EXPECT_EQ(interval->high, 0.0);
}

// A curved path whose estimate has errors of 0.1 m per axis that `memory` consecutive poses share
// in part.
PosePairs NoisyPairs(std::size_t count, std::size_t memory, std::mt19937* random) {
  std::normal_distribution<double> noise(0.0, 0.1 / std::sqrt(static_cast<double>(memory)));
  std::vector<Eigen::Vector3d> draws(count + memory);
  for (auto& draw : draws) draw = {noise(*random), noise(*random), noise(*random)};
  PosePairs pairs;
  for (std::size_t i = 0; i < count; ++i) {
    const double t = 0.3 * static_cast<double>(i);
    pairs.reference.push_back(
        {Eigen::Matrix3d::Identity(), {8 * std::cos(t), 5 * std::sin(t), std::sin(2.3 * t)}});
    pairs.estimate.push_back(pairs.reference.back());
    for (std::size_t k = 0; k < memory; ++k) pairs.estimate.back().translation += draws[i + k];
  }
  return pairs;
}

// Share of intervals that hold the expected rmse, sqrt(3) sigma.
double Coverage(std::size_t count, std::size_t memory) {
  std::mt19937 random(5);
  constexpr int kTrials = 400;
  int held = 0;
  for (int trial = 0; trial < kTrials; ++trial) {
    const PosePairs pairs = NoisyPairs(count, memory, &random);
    const AteResult ate = ComputeAte(pairs, PoseAlignment::kNone);
    std::vector<double> without;
    for (const auto& rest : AteWithoutBlocks(pairs, ate, 20)) {
      without.push_back(rest.translation.rmse);
    }
    const auto interval = JackknifeMagnitude(ate.errors.translation.rmse, without, 0.95);
    held += interval->low <= 0.1 * std::sqrt(3.0) && interval->high >= 0.1 * std::sqrt(3.0);
  }
  return held / static_cast<double>(kTrials);
}

TEST(Jackknife, IntervalsHoldTheTruthAsOftenAsTheySay) {
  EXPECT_NEAR(Coverage(7, 1), 0.95, 0.04);
  EXPECT_NEAR(Coverage(200, 1), 0.95, 0.03);
  EXPECT_NEAR(Coverage(400, 5), 0.95, 0.04);  // neighbouring errors alike
}

TEST(Jackknife, AlignsAnewWithoutEachBlock) {
  std::mt19937 random(9);
  const PosePairs pairs = NoisyPairs(40, 1, &random);
  const AteResult ate = ComputeAte(pairs, PoseAlignment::kSe3);
  const auto without = AteWithoutBlocks(pairs, ate, 20);
  ASSERT_EQ(without.size(), 20u);
  PosePairs rest = pairs;
  rest.reference.erase(rest.reference.begin(), rest.reference.begin() + 2);
  rest.estimate.erase(rest.estimate.begin(), rest.estimate.begin() + 2);
  EXPECT_EQ(without[0].translation.rmse,
            ComputeAte(rest, PoseAlignment::kSe3).errors.translation.rmse);
  EXPECT_EQ(without[0].count, 38u);
}

TEST(Jackknife, OverlappingPairsGoInLongerBlocks) {
  std::mt19937 random(9);
  const PosePairs pairs = NoisyPairs(100, 1, &random);
  RpeOptions options;
  options.delta = 10;
  EXPECT_EQ(RpeWithoutBlocks(ComputeRpe(pairs, options), 20).size(), 9u);
  options.all_pairs = true;
  EXPECT_EQ(RpeWithoutBlocks(ComputeRpe(pairs, options), 20).size(), 9u);  // 90 pairs of reach 10
  options.delta = 60;
  EXPECT_TRUE(RpeWithoutBlocks(ComputeRpe(pairs, options), 20).empty());
}

}  // namespace
}  // namespace planegraph
