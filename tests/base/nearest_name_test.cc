#include "planegraph/base/nearest_name.h"

#include <gtest/gtest.h>

namespace planegraph {
namespace {

const std::vector<std::string> kNames = {"output_dir", "optimizer", "map_voxel", "map_tiles"};

TEST(NearestName, SlipsOfTheFinger) {
  EXPECT_EQ(NearestName("outputdir", kNames), "output_dir");
  EXPECT_EQ(NearestName("optimiser", kNames), "optimizer");
  EXPECT_EQ(NearestName("map-voxel", kNames), "map_voxel");
  EXPECT_EQ(NearestName("map_tiles", kNames), "map_tiles");
}

TEST(NearestName, TheOnlyOneThatItBegins) {
  EXPECT_EQ(NearestName("out", kNames), "output_dir");
  EXPECT_EQ(NearestName("map_", kNames), "");
}

TEST(NearestName, NothingWhereNoneIsNear) {
  EXPECT_EQ(NearestName("colour", kNames), "");
  EXPECT_EQ(NearestName("", kNames), "");
  EXPECT_EQ(NearestName("output", {}), "");
}

}  // namespace
}  // namespace planegraph
