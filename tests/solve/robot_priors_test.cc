// What a robot's receiver and gravity say in the graph.
#include <gtest/gtest.h>

#include <cmath>

#include "planegraph/base/error.h"
#include "planegraph/geometry/rotation.h"
#include "planegraph/solve/solver.h"

namespace planegraph {
namespace {

PoseFactor PositionOf(int pose, const Eigen::Vector3d& antenna, const Eigen::Vector3d& position,
                      double sigma) {
  PoseFactor factor;
  factor.type = "robot_position";
  factor.poses = {pose};
  factor.point = antenna;
  factor.measurement.translation = position;
  factor.information.setZero();
  factor.information.diagonal().head<3>().setConstant(std::pow(sigma, -2));
  factor.source = "gps";
  return factor;
}

PoseFactor GravityOf(int pose, const Eigen::Vector3d& up, double sigma) {
  PoseFactor factor;
  factor.type = "gravity";
  factor.poses = {pose};
  factor.point = up;
  factor.measurement.translation = Eigen::Vector3d::UnitZ();
  factor.information.setZero();
  factor.information.diagonal().tail<3>().setConstant(std::pow(sigma, -2));
  factor.source = "gravity";
  return factor;
}

// One fix is far off: a loss of its factor's own switches it off and leaves the others alone.
TEST(FactorLosses, AreOfTheirTypeAlone) {
  Graph graph;
  for (int k = 0; k < 6; ++k) {
    graph.poses.push_back(
        {std::to_string(k), {Eigen::Quaterniond::Identity(), {2.0 * k, 0, 0}}, k == 0});
    graph.pose_factors.push_back(PositionOf(k, {0, 0, 0}, {2.0 * k, k == 4 ? 5.0 : 0.0, 0}, 0.5));
    graph.pose_factors.back().robust = true;
    if (k == 0) continue;
    const Rigid3 step(Eigen::Quaterniond::Identity(), {2, 0, 0});
    graph.pose_factors.push_back(
        MakeRelativePose(k - 1, k, step, 1e2 * Matrix6d::Identity(), "odometry"));
    graph.pose_factors.back().robust = true;
  }
  const Graph start = graph;
  const auto off = [&](const SolveOptions& options) {
    graph = start;
    const SolveSummary summary = Solve(&graph, options);
    for (const ResidualReport& report : summary.residuals) {
      const PoseFactor& factor = graph.pose_factors[report.tag.pose_factor];
      const bool wrong = factor.type == "robot_position" && factor.poses[0] == 4;
      if (!options.factor_losses.empty()) {
        EXPECT_EQ(report.weight < 0.01, wrong) << factor.type;
        EXPECT_TRUE(factor.type == "robot_position" || report.weight == 1.0);
      }
    }
    return graph.poses[4].world_from_node.translation.norm() - 8.0;
  };
  SolveOptions options;
  EXPECT_GT(off(options), 0.01);
  for (const char* loss : {"tukey:3", "gnc_tls"}) {
    options.factor_losses = {{"robot_position", ParseLoss(loss)}};
    EXPECT_NEAR(off(options), 0.0, 1e-3) << loss;
  }
  options.factor_losses = {{"gps", ParseLoss("tukey:3")}};
  EXPECT_THROW(Solve(&graph, options), UsageError);
}

// A stiff chain whose antenna was measured at every pose: its place and heading follow.
TEST(RobotPosition, PlacesAChain) {
  const Eigen::Vector3d antenna(0.3, -0.2, 0.8);
  std::vector<Rigid3> truth;
  for (int k = 0; k < 5; ++k) {
    truth.push_back({ExpSO3({0.02 * k, -0.03, 0.7 + 0.4 * k}),
                     {10.0 + 3.0 * k, -4.0 + 0.5 * k * k, 1.0 + 0.2 * k}});
  }
  const Rigid3 displaced{ExpSO3({0.05, 0.1, 1.0}), {40.0, -20.0, 3.0}};
  Graph graph;
  for (int k = 0; k < 5; ++k) {
    graph.poses.push_back({std::to_string(k), displaced * truth[k], false});
    graph.pose_factors.push_back(PositionOf(k, antenna, truth[k] * antenna, 1.0));
    if (k == 0) continue;
    graph.pose_factors.push_back(MakeRelativePose(k - 1, k, truth[k - 1].Inverse() * truth[k],
                                                  1e4 * Matrix6d::Identity(), "registration"));
  }
  const SolveSummary summary = Solve(&graph);
  EXPECT_TRUE(summary.converged);
  EXPECT_LT(summary.final_cost, 1e-9);
  for (int k = 0; k < 5; ++k) {
    EXPECT_LT((graph.poses[k].world_from_node.translation - truth[k].translation).norm(), 1e-4);
    EXPECT_LT(AngleBetween(graph.poses[k].world_from_node.rotation, truth[k].rotation), 1e-4);
  }
}

// Two measurements of a tilt: the mean by their weights, and the heading stays.
TEST(Gravity, TiesTheTiltAndLeavesTheHeading) {
  const Eigen::Quaterniond heading = ExpSO3({0.0, 0.0, 0.8});
  const double tilt = 0.02;
  Graph graph;
  graph.poses.push_back({"0", {heading, {1, 2, 3}}, false});
  Matrix6d information = 1e6 * Matrix6d::Identity();
  information.diagonal().tail<3>().setConstant(std::pow(0.02, -2));
  graph.pose_factors.push_back(MakePosePrior(0, {heading, {1, 2, 3}}, information));
  // The scan says that its own axis is tilted about the world's x axis; twice as sure.
  const Eigen::Vector3d up =
      (ExpSO3({tilt, 0, 0}) * heading).conjugate() * Eigen::Vector3d::UnitZ();
  graph.pose_factors.push_back(GravityOf(0, up, 0.01));
  Solve(&graph);
  const Eigen::Vector3d turned =
      LogSO3(graph.poses[0].world_from_node.rotation * heading.conjugate());
  EXPECT_NEAR(turned.x(), tilt * 4.0 / 5.0, 1e-5);
  EXPECT_NEAR(turned.y(), 0.0, 1e-5);
  EXPECT_NEAR(turned.z(), 0.0, 1e-5);
}

TEST(MapGravity, TiesTheTiltOfAMap) {
  const Eigen::Vector3d up = Eigen::Vector3d(0.3, -0.8, 0.5).normalized();
  Graph graph;
  graph.poses.push_back({"0", {}, true});
  graph.maps.push_back({"m", Sim3(2.0, ExpSO3({0.6, 0.4, -0.3}), {5, 6, 7}), false});
  MapFactor factor;
  factor.type = "map_gravity";
  factor.maps = {0};
  factor.point = up;
  factor.position = Eigen::Vector3d::UnitZ();
  factor.information.setZero();
  factor.information.block<3, 3>(3, 3) = 1e4 * Eigen::Matrix3d::Identity();
  graph.map_factors.push_back(factor);
  Solve(&graph);
  const Sim3& found = graph.maps[0].world_from_map;
  EXPECT_LT((found.rotation * up - Eigen::Vector3d::UnitZ()).norm(), 1e-6);
  EXPECT_NEAR(found.scale, 2.0, 1e-6);
}

}  // namespace
}  // namespace planegraph
