#include "planegraph/cloud/voxel_key.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <map>
#include <random>

namespace planegraph {
namespace {

TEST(VoxelKey, IsThatOfAnotherPointInTheSameVoxelAlone) {
  std::mt19937_64 engine(1);
  std::uniform_real_distribution<double> uniform(-2.0, 2.0);
  const double voxel = 0.25;
  std::map<std::array<double, 3>, std::uint64_t> keys;
  std::map<std::uint64_t, std::array<double, 3>> cells;
  for (int k = 0; k < 20000; ++k) {
    const Eigen::Vector3d point(uniform(engine), uniform(engine), uniform(engine));
    std::array<double, 3> cell;
    for (int axis = 0; axis < 3; ++axis) cell[axis] = std::floor(point[axis] / voxel);
    const std::uint64_t key = VoxelKey(point, voxel);
    ASSERT_NE(key, kNoVoxel);
    EXPECT_EQ(keys.emplace(cell, key).first->second, key);
    EXPECT_EQ(cells.emplace(key, cell).first->second, cell);
  }
  EXPECT_EQ(keys.size(), cells.size());
  EXPECT_GT(keys.size(), 4000u);
}

TEST(VoxelKey, EndsWhereItsBitsDo) {
  for (int axis = 0; axis < 3; ++axis) {
    for (const double sign : {-1.0, 1.0}) {
      Eigen::Vector3d point = Eigen::Vector3d::Zero();
      point[axis] = sign * (kMostVoxels - 1.5);
      EXPECT_NE(VoxelKey(point, 1.0), kNoVoxel);
      for (const double far : {kMostVoxels + 0.5, 1e30, double(INFINITY), double(NAN)}) {
        point[axis] = sign * far;
        EXPECT_EQ(VoxelKey(point, 1.0), kNoVoxel) << far;
      }
    }
  }
}

}  // namespace
}  // namespace planegraph
