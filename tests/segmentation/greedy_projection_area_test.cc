#include "segmentation/greedy_projection_area.h"

#include <gtest/gtest.h>

#include <random>

#include "planegraph/base/error.h"
#include "planegraph/segmentation/segmenter.h"

namespace planegraph {
namespace {

bool HasPcl() {
  try {
    GreedyProjectionArea({});
  } catch (const UsageError&) {
    return false;
  }
  return true;
}

std::vector<Eigen::Vector2d> Sample(double width, double height, double per_metre2) {
  std::mt19937_64 rng(1);
  std::uniform_real_distribution<double> uniform;
  std::vector<Eigen::Vector2d> points;
  for (int i = 0; i < per_metre2 * width * height; ++i) {
    const double x = width * uniform(rng), y = height * uniform(rng);
    points.emplace_back(x, y);
  }
  return points;
}

TEST(GreedyProjectionAreaTest, RectangleAndItsHole) {
  if (!HasPcl()) GTEST_SKIP() << "built without PCL";
  auto points = Sample(4, 3, 800);
  // Holes along the border and within take a few per cent.
  EXPECT_NEAR(GreedyProjectionArea(points), 12.0, 0.6);
  std::erase_if(points, [](const auto& p) { return p.x() > 1 && p.x() < 3 && p.y() < 2; });
  EXPECT_NEAR(GreedyProjectionArea(points), 8.0, 0.6);
}

TEST(GreedyProjectionAreaTest, TooFewPointsHaveNoArea) {
  if (!HasPcl()) GTEST_SKIP() << "built without PCL";
  EXPECT_EQ(GreedyProjectionArea({{0, 0}, {1, 0}}), 0.0);
}

TEST(GreedyProjectionAreaTest, TheSegmentationTakesItWhereAsked) {
  Cloud cloud;
  for (const auto& p : Sample(4, 3, 800)) {
    cloud.points.emplace_back(static_cast<float>(p.x()), static_cast<float>(p.y()), 0.0F);
  }
  cloud.viewpoint = {2, 1, 2};
  SegmentationOptions options;
  options.noise = NoiseModel{0.01, 0.0};
  options.greedy_projection_area = true;
  if (!HasPcl()) {
    EXPECT_THROW(SegmentPlanes(cloud, options), UsageError);
    return;
  }
  const auto segments = SegmentPlanes(cloud, options).planes.planes;
  ASSERT_EQ(segments.size(), 1u);
  EXPECT_NEAR(segments[0].area, 12.0, 0.6);
}

}  // namespace
}  // namespace planegraph
