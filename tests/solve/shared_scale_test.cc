// Measurements with one scale in common: what all of them err by is not found out by their number.
#include <gtest/gtest.h>

#include "planegraph/solve/covariance.h"
#include "planegraph/solve/solver.h"

namespace planegraph {
namespace {

constexpr double kStep = 2.0, kOwn = 0.05, kCommon = 0.03, kTurn = 1e-4;

// Straight along x, `scale` true metres in a metre of the odometry.
Graph Walk(int steps, double scale) {
  Graph graph;
  graph.scales.push_back({"robot"});
  graph.pose_factors.push_back(MakeScalePrior(0, 1.0, kCommon));
  Matrix6d information = Matrix6d::Identity() / (kOwn * kOwn);
  information.bottomRightCorner<3, 3>() = Eigen::Matrix3d::Identity() / (kTurn * kTurn);
  for (int i = 0; i <= steps; ++i) {
    Rigid3 pose;
    pose.translation.x() = kStep * scale * i;
    graph.poses.push_back({std::to_string(i), pose, i == 0});
    if (i == 0) continue;
    Rigid3 step;
    step.translation.x() = kStep;
    PoseFactor factor = MakeRelativePose(i - 1, i, step, information, "odometry");
    factor.type = "odometry_step";
    factor.scale = 0;
    graph.pose_factors.push_back(factor);
  }
  return graph;
}

TEST(SharedScale, CommonErrorsGrowWithTheWayOwnOnesWithItsRoot) {
  constexpr int kSteps = 20;
  const Graph graph = Walk(kSteps, 1.0);
  const GraphCovariance covariance(graph);
  for (int i = 1; i <= kSteps; ++i) {
    const double own = i * kOwn * kOwn, common = std::pow(i * kStep * kCommon, 2);
    EXPECT_NEAR(covariance.Pose(i)(0, 0), own + common, 1e-7 * (own + common)) << i;
  }
  EXPECT_NEAR(covariance.Scale(0) / (kCommon * kCommon), 1.0, 1e-7);
}

TEST(SharedScale, IsFoundWhereTheEndIsKnown) {
  constexpr int kSteps = 10;
  constexpr double kTrue = 1.02, kEnd = 1e-3;
  Graph graph = Walk(kSteps, kTrue);
  const Rigid3 end = graph.poses.back().world_from_node;
  graph.pose_factors.push_back(MakePosePrior(kSteps, end, Matrix6d::Identity() / (kEnd * kEnd)));
  const SolveSummary summary = Solve(&graph, {});
  ASSERT_TRUE(summary.converged) << summary.message;
  // The whole way as one measurement of the scale, beside its prior.
  const double way = kSteps * kStep;
  const double measured = way * way / (kSteps * kOwn * kOwn + kEnd * kEnd);
  const double information = measured + 1.0 / (kCommon * kCommon);
  EXPECT_NEAR(graph.scales[0].scale - 1.0, (kTrue - 1.0) * measured / information, 1e-8);
  EXPECT_NEAR(GraphCovariance(graph).Scale(0) * information, 1.0, 1e-6);
}

TEST(SharedScale, OfOneHasNoSayInTheOther) {
  Graph graph = Walk(3, 1.0);
  graph.scales.push_back({"another robot"});
  graph.pose_factors.push_back(MakeScalePrior(1, 1.0, 0.1));
  const GraphCovariance covariance(graph);
  EXPECT_NEAR(covariance.Scale(0) / (kCommon * kCommon), 1.0, 1e-7);
  EXPECT_NEAR(covariance.Scale(1) / 0.01, 1.0, 1e-7);
}

TEST(SharedScale, MustExist) {
  Graph graph = Walk(2, 1.0);
  graph.pose_factors.back().scale = 1;
  EXPECT_THROW(CheckGraph(graph), std::invalid_argument);
  graph.pose_factors.back().scale = 0;
  graph.scales[0].scale = 0.0;
  EXPECT_THROW(CheckGraph(graph), std::invalid_argument);
}

}  // namespace
}  // namespace planegraph
