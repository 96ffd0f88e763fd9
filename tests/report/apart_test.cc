#include "planegraph/report/apart.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace planegraph {
namespace {

using testing::EndsWith;

TEST(Apart, NamesTheScansOfTheSmallerComponents) {
  EXPECT_EQ(ApartText({{"cart/000", 0},
                       {"cart/001", 0},
                       {"cart/002", 0},
                       {"cart/003", 1},
                       {"cart/004", 2},
                       {"cart/005", 2},
                       {"ugv/000", 2}}),
            "cart/003 | cart/004 to 005, ugv/000 stand apart");
}

TEST(Apart, OneScanStandsApart) {
  EXPECT_EQ(ApartText({{"cart/000", 0}, {"cart/001", 1}, {"cart/002", 0}}),
            "cart/001 stands apart");
}

TEST(Apart, TheMapIsTheLargestComponentWhateverItsNumber) {
  const std::vector<ComponentScan> scans = {{"cart/000", 0}, {"cart/001", 7}, {"cart/002", 7}};
  EXPECT_EQ(MainComponent(scans), 7);
  EXPECT_EQ(ApartText(scans), "cart/000 stands apart");
  EXPECT_EQ(MainComponent({{"a", 3}, {"b", 1}}), 1);  // of equal ones the first
  EXPECT_EQ(MainComponent({}), -1);
}

TEST(Apart, NobodyWhereTheMapIsWhole) {
  EXPECT_EQ(ApartText({}), "");
  EXPECT_EQ(ApartText({{"cart/000", 4}, {"cart/001", 4}}), "");
}

TEST(Apart, OfManyTheFirstFewAreNamed) {
  std::vector<ComponentScan> scans = {{"cart/100", 0}, {"cart/101", 0}};
  for (int i = 0; i < 9; ++i) scans.push_back({"cart/" + std::to_string(i), i + 1});
  EXPECT_THAT(ApartText(scans), EndsWith("cart/4 | ... stand apart"));
  std::vector<ComponentScan> runs(20, {"cart/0", 0});
  for (int i = 0; i < 10; i += 2) runs[i] = {"ugv/" + std::to_string(i), 1};
  EXPECT_EQ(ApartText(runs), "ugv/0, ugv/2, ugv/4, ... stand apart");
}

}  // namespace
}  // namespace planegraph
