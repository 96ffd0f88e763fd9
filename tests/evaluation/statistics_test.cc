#include "planegraph/evaluation/statistics.h"

#include <gtest/gtest.h>

#include <cmath>

#include "planegraph/base/error.h"

namespace planegraph {
namespace {

TEST(Summarize, KnownValues) {
  const Statistics s = Summarize({4.0, 1.0, 3.0, 2.0});
  EXPECT_DOUBLE_EQ(s.mean, 2.5);
  EXPECT_DOUBLE_EQ(s.median, 2.5);
  EXPECT_DOUBLE_EQ(s.rmse, std::sqrt(7.5));
  EXPECT_DOUBLE_EQ(s.std, std::sqrt(1.25));
  EXPECT_DOUBLE_EQ(s.min, 1.0);
  EXPECT_DOUBLE_EQ(s.max, 4.0);
}

TEST(Summarize, MedianOfOddCount) { EXPECT_DOUBLE_EQ(Summarize({9.0, 1.0, 5.0}).median, 5.0); }

TEST(Summarize, NothingIsNoResult) { EXPECT_THROW(Summarize({}), NoResultError); }

}  // namespace
}  // namespace planegraph
