#include "planegraph/base/disjoint_sets.h"

#include <gtest/gtest.h>

namespace planegraph {
namespace {

TEST(DisjointSets, TheSmallestMemberStandsForItsSet) {
  DisjointSets sets(6);
  EXPECT_EQ(sets.Find(3), 3u);
  sets.Join(5, 3);
  sets.Join(3, 4);
  sets.Join(4, 1);
  sets.Join(1, 5);
  for (const std::size_t i : {1, 3, 4, 5}) EXPECT_EQ(sets.Find(i), 1u);
  EXPECT_EQ(sets.Find(0), 0u);
  EXPECT_EQ(sets.Find(2), 2u);
}

}  // namespace
}  // namespace planegraph
