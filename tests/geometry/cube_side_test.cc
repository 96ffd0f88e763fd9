#include "planegraph/geometry/cube_side.h"

#include <gtest/gtest.h>

#include <random>

namespace planegraph {
namespace {

TEST(CubeSide, IsTheNearestAxis) {
  std::mt19937_64 engine(5);
  std::normal_distribution<double> normal;
  for (int run = 0; run < 1000; ++run) {
    const Eigen::Vector3d d(normal(engine), normal(engine), normal(engine));
    Eigen::Index axis = 0;
    d.cwiseAbs().maxCoeff(&axis);
    EXPECT_EQ(CubeSide(d), 2 * axis + (d[axis] < 0 ? 1 : 0));
    EXPECT_EQ(CubeSide(Eigen::Vector3d(-d)), CubeSide(d) ^ 1);
  }
}

TEST(CubeSide, OfEqualAxesTheFirst) {
  EXPECT_EQ(CubeSide(Eigen::Vector3f(1, -1, 1)), 0);
  EXPECT_EQ(CubeSide(Eigen::Vector3f(0, -1, 1)), 3);
}

}  // namespace
}  // namespace planegraph
