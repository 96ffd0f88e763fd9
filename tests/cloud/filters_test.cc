#include "planegraph/cloud/filters.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <random>

#include "planegraph/base/error.h"
#include "planegraph/cloud/kd_tree.h"
#include "planegraph/cloud/normals.h"

namespace planegraph {
namespace {

Cloud MakeCloud(const std::vector<Eigen::Vector3f>& points) {
  Cloud cloud;
  cloud.points = points;
  return cloud;
}

Cloud RandomCloud(std::size_t count, float size, std::uint64_t seed = 1) {
  std::mt19937_64 rng(seed);
  std::uniform_real_distribution<float> uniform(-size, size);
  Cloud cloud;
  for (std::size_t i = 0; i < count; ++i) {
    const float x = uniform(rng), y = uniform(rng), z = uniform(rng);
    cloud.points.emplace_back(x, y, z);
  }
  return cloud;
}

// A square metre of ground at z = 0, 1 cm apart, seen from 1 m above.
Cloud Ground() {
  Cloud cloud;
  for (int i = 0; i < 100; ++i) {
    for (int j = 0; j < 100; ++j) cloud.points.emplace_back(0.01F * i, 0.01F * j, 0.0F);
  }
  cloud.viewpoint = {0.5, 0.5, 1.0};
  return cloud;
}

std::vector<FilterStep> Step(const std::string& name, const std::map<std::string, double>& p) {
  return {{name, p}};
}

TEST(KdTreeTest, AgreesWithBruteForce) {
  const Cloud cloud = RandomCloud(500, 5);
  const KdTree tree(cloud.points);
  for (const auto& query : RandomCloud(50, 5, 2).points) {
    std::vector<float> squares;
    for (const auto& p : cloud.points) squares.push_back((p - query).squaredNorm());
    std::sort(squares.begin(), squares.end());
    std::vector<KdTree::Neighbour> near;
    tree.Nearest(query, 7, &near);
    ASSERT_EQ(near.size(), 7u);
    for (int k = 0; k < 7; ++k) EXPECT_NEAR(near[k].squared_distance, squares[k], 1e-4);
    tree.Within(query, 1.5F, &near);
    EXPECT_EQ(near.size(), std::size_t(std::upper_bound(squares.begin(), squares.end(), 2.25F) -
                                       squares.begin()));
  }
}

TEST(KdTreeTest, SmallAndEmptyClouds) {
  const std::vector<Eigen::Vector3f> none, two = {{0, 0, 0}, {1, 0, 0}};
  std::vector<KdTree::Neighbour> near(3);
  KdTree(none).Nearest({0, 0, 0}, 5, &near);
  EXPECT_TRUE(near.empty());
  KdTree(two).Nearest({0.9F, 0, 0}, 5, &near);
  ASSERT_EQ(near.size(), 2u);
  EXPECT_EQ(near[0].index, 1u);
}

TEST(VoxelFilterTest, CentroidOrFirst) {
  Cloud cloud = MakeCloud({{0.1F, 0.1F, 0.1F}, {5, 5, 5}, {0.3F, 0.3F, 0.3F}, {-0.1F, 0.1F, 0.1F}});
  cloud.colors = {{10, 0, 0}, {1, 2, 3}, {20, 0, 0}, {9, 9, 9}};
  const Cloud mean = VoxelFilter(cloud, 1.0);
  ASSERT_EQ(mean.size(), 3u);
  EXPECT_NEAR(mean.points[0].x(), 0.2, 1e-6);
  EXPECT_EQ(mean.colors[0][0], 15);
  EXPECT_EQ(mean.colors[1][2], 3);
  const Cloud first = VoxelFilter(cloud, 1.0, VoxelPoint::kFirst);
  ASSERT_EQ(first.size(), 3u);
  EXPECT_EQ(first.points[0], cloud.points[0]);
}

TEST(VoxelFilterTest, FarAndFineDoesNotOverflow) {
  // PCL's 32-bit index overflows here: 2e5 cells along each of three axes.
  const Cloud cloud = MakeCloud({{0, 0, 0}, {2000, 2000, 2000}, {2000, 0, 0}, {0.001F, 0, 0}});
  EXPECT_EQ(VoxelFilter(cloud, 0.01).size(), 3u);
  EXPECT_THROW(VoxelFilter(cloud, 1e-4), UsageError);
  EXPECT_THROW(VoxelFilter(cloud, 0.0), UsageError);
}

TEST(VoxelFilterProperty, AgainChangesNothingForFirstPoints) {
  const Cloud once = VoxelFilter(RandomCloud(5000, 3), 0.5, VoxelPoint::kFirst);
  EXPECT_EQ(VoxelFilter(once, 0.5, VoxelPoint::kFirst).points, once.points);
  EXPECT_LE(once.size(), 13u * 13 * 13);
}

TEST(OutlierFilterTest, DropsTheLonelyPoint) {
  Cloud cloud = Ground();
  cloud.points.emplace_back(0.5F, 0.5F, 3.0F);
  const Cloud kept = OutlierFilter(cloud, 20, 3.0);
  EXPECT_GT(kept.size(), 9900u);
  EXPECT_TRUE(std::all_of(kept.points.begin(), kept.points.end(),
                          [](const auto& p) { return p.z() == 0; }));
  EXPECT_EQ(OutlierFilter(cloud, 20, 3.0, 3).points, kept.points);
}

TEST(RangeFilterTest, CountsFromTheViewpointWithTheOffset) {
  Cloud cloud = MakeCloud({{0, 0, 0}, {1, 0, 0}, {5, 0, 0}});
  cloud.offset = {1000, 0, 0};
  cloud.viewpoint = {1000, 0, 0};
  const Cloud kept = RangeFilter(cloud, 0.5, 2.0);
  ASSERT_EQ(kept.size(), 1u);
  EXPECT_EQ(kept.points[0].x(), 1);
}

TEST(NormalsTest, PointTowardsTheViewpoint) {
  Cloud cloud = Ground();
  for (const auto& n : WithNormals(cloud, 12).normals) EXPECT_NEAR(n.z(), 1.0, 1e-4);
  cloud.viewpoint.z() = -1.0;
  for (const auto& n : WithNormals(cloud, 12).normals) EXPECT_NEAR(n.z(), -1.0, 1e-4);
}

TEST(IncidenceFilterTest, DropsGrazingBeams) {
  EXPECT_THROW(IncidenceFilter(Ground(), 45), UsageError);
  Cloud cloud = WithNormals(Ground(), 12);
  cloud.viewpoint = {0, 0.5, 0.5};
  const Cloud kept = IncidenceFilter(cloud, 45);
  EXPECT_GT(kept.size(), 0u);
  for (const auto& p : kept.points) EXPECT_LT(std::hypot(p.x(), p.y() - 0.5F), 0.501F);
  EXPECT_LT(kept.size(), cloud.size());
}

TEST(FilterChainTest, AppliesInOrder) {
  const FilterChain chain({{"range", {{"min", 0.5}}}, {"voxel", {{"size", 0.1}}}, {"normals", {}}});
  Cloud cloud = Ground();
  cloud.points.emplace_back(0.5F, 0.5F, 0.9F);
  const Cloud out = chain.Apply(cloud);
  EXPECT_EQ(out.size(), 100u);
  EXPECT_EQ(out.normals.size(), out.size());
  EXPECT_TRUE(FilterChain().empty());
}

TEST(FilterChainTest, WrongUsageIsSaidAtOnce) {
  using testing::HasSubstr;
  const auto message = [](const std::vector<FilterStep>& steps) {
    try {
      FilterChain chain(steps);
    } catch (const UsageError& error) {
      return std::string(error.what());
    }
    return std::string();
  };
  EXPECT_THAT(message(Step("voxle", {})), HasSubstr("unknown filter `voxle`"));
  EXPECT_THAT(message(Step("voxel", {{"sise", 1}})), HasSubstr("no parameter `sise`"));
  EXPECT_THAT(message(Step("voxel", {{"size", 0}})), HasSubstr("`size` must be positive"));
  EXPECT_THAT(message(Step("outlier", {{"k", 2.5}})), HasSubstr("whole number"));
  EXPECT_THAT(message(Step("range", {{"min", NAN}})), HasSubstr("`min`"));
}

TEST(FilterChainTest, EveryFilterHasADescriptionAndWorksOnNothing) {
  ASSERT_EQ(ListFilters().size(), 5u);
  for (const auto& description : ListFilters()) {
    EXPECT_FALSE(description.help.empty());
    EXPECT_EQ(FilterChain(Step(description.name, {})).Apply(Cloud()).size(), 0u);
  }
}

}  // namespace
}  // namespace planegraph
