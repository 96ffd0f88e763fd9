#include "segmentation/cell_octree.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>

namespace planegraph {
namespace {

Cloud RandomCloud(int count, double extent) {
  std::mt19937_64 engine(5);
  std::uniform_real_distribution<float> uniform(static_cast<float>(-extent),
                                                static_cast<float>(extent));
  Cloud cloud;
  for (int i = 0; i < count; ++i) {
    cloud.points.push_back({uniform(engine), uniform(engine), uniform(engine)});
  }
  return cloud;
}

TEST(CellOctree, SumsEqualTheSumsOfTheirPoints) {
  const CellOctree octree(RandomCloud(3000, 2.0), 0.2, 4);
  for (int level = 0; level < octree.levels(); ++level) {
    double points = 0;
    for (std::uint32_t c = 0; c < octree.Level(level).size(); ++c) {
      const auto& cell = octree.Level(level)[c];
      Moments brute;
      for (std::uint32_t i = 0; i < cell.point_count; ++i) {
        brute.Add(octree.sorted_points()[cell.first_point + i].cast<double>());
      }
      const Moments fast = octree.Sums(level, c).ToMoments();
      EXPECT_EQ(fast.count, brute.count);
      EXPECT_LT((fast.mean - brute.mean).norm(), 1e-12);
      EXPECT_LT((fast.scatter - brute.scatter).norm(), 1e-9);
      points += fast.count;
    }
    EXPECT_EQ(points, 3000);
  }
}

TEST(CellOctree, EveryPointLiesInItsCellAndIsThereOnce) {
  const Cloud cloud = RandomCloud(2000, 3.0);
  const CellOctree octree(cloud, 0.25, 3);
  std::vector<int> seen(cloud.size(), 0);
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    ++seen[octree.order()[i]];
    EXPECT_EQ(octree.sorted_points()[i], cloud.points[octree.order()[i]]);
  }
  EXPECT_EQ(std::count(seen.begin(), seen.end(), 1), static_cast<int>(cloud.size()));
  for (int level = 0; level < octree.levels(); ++level) {
    for (const auto& cell : octree.Level(level)) {
      const Eigen::Vector3f& first = octree.sorted_points()[cell.first_point];
      for (std::uint32_t i = 1; i < cell.point_count; ++i) {
        const auto d = octree.sorted_points()[cell.first_point + i] - first;
        EXPECT_LE(d.cwiseAbs().maxCoeff(), octree.CellSize(level) + 1e-5);
      }
    }
  }
}

TEST(CellOctree, ChildrenAndParentsAgree) {
  const CellOctree octree(RandomCloud(2000, 3.0), 0.25, 4);
  for (int level = 1; level < octree.levels(); ++level) {
    std::size_t children = 0;
    for (std::uint32_t i = 0; i < octree.Level(level).size(); ++i) {
      const auto& cell = octree.Level(level)[i];
      for (std::uint32_t k = 0; k < cell.child_count; ++k, ++children) {
        const auto& child = octree.Level(level - 1)[cell.first_child + k];
        EXPECT_EQ(CellOctree::Coordinates(child.key) / 2, CellOctree::Coordinates(cell.key));
      }
    }
    EXPECT_EQ(children, octree.Level(level - 1).size());
  }
}

TEST(CellOctree, FindsExactlyTheOccupiedCells) {
  const CellOctree octree(RandomCloud(500, 1.0), 0.3, 2);
  for (int level = 0; level < octree.levels(); ++level) {
    for (std::uint32_t i = 0; i < octree.Level(level).size(); ++i) {
      const Eigen::Vector3i at = CellOctree::Coordinates(octree.Level(level)[i].key);
      EXPECT_EQ(octree.Find(level, at), static_cast<int>(i));
    }
    EXPECT_EQ(octree.Find(level, {5, 5, 5}), -1);
  }
}

TEST(NeighbourKeys, AreTheCodesOfTheCellsAround) {
  const CellOctree octree(RandomCloud(300, 20.0), 0.1, 3);
  for (int level = 0; level < octree.levels(); ++level) {
    for (const auto& cell : octree.Level(level)) {
      const Eigen::Vector3i at = CellOctree::Coordinates(cell.key);
      const NeighbourKeys keys(cell.key);
      for (int k = 0; k < 27; ++k) {
        const Eigen::Vector3i step(k % 3 - 1, k / 3 % 3 - 1, k / 9 - 1);
        ASSERT_EQ(CellOctree::Coordinates(keys.At(k)), at + step);
        ASSERT_EQ(octree.Find(level, keys.At(k)), octree.Find(level, at + step));
      }
    }
  }
}

TEST(CellOctree, EmptyAndFarTooLargeClouds) {
  const CellOctree empty(Cloud(), 0.1, 3);
  for (int level = 0; level < 3; ++level) {
    EXPECT_TRUE(empty.Level(level).empty());
    EXPECT_EQ(empty.Find(level, {1, 2, 3}), -1);
  }
  Cloud huge;
  huge.points = {{0, 0, 0}, {1e30f, 0, 0}};
  EXPECT_THROW(CellOctree(huge, 0.1, 3), std::length_error);
}

}  // namespace
}  // namespace planegraph
