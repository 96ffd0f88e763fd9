#include "planegraph/solve/solver.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cstring>

#include "planegraph/base/error.h"
#include "solve/plane_world.h"

namespace planegraph {
namespace {

class RecoversTruth : public testing::TestWithParam<const char*> {};

TEST_P(RecoversTruth, FromDisturbedPoses) {
  PlaneWorld world({.poses = 8, .planes = 60});
  Graph graph = world.Disturbed(0.3, 0.1);
  ASSERT_GT(LargestPoseDifference(graph, world.truth()), 0.1);
  SolveOptions options;
  options.plane_factor = GetParam();
  const SolveSummary summary = Solve(&graph, options);
  EXPECT_TRUE(summary.converged);
  EXPECT_LT(summary.final_cost, 1e-12);
  EXPECT_LT(LargestPoseDifference(graph, world.truth()), 1e-9);
  for (std::size_t k = 0; k < graph.planes.size(); ++k) {
    const double agreement = graph.planes[k].normal.dot(world.truth().planes[k].normal);
    EXPECT_NEAR(std::abs(agreement), 1.0, 1e-12);
    EXPECT_NEAR(graph.planes[k].offset, agreement * world.truth().planes[k].offset, 1e-8);
  }
}

INSTANTIATE_TEST_SUITE_P(PlaneFactors, RecoversTruth,
                         testing::Values("moments", "pose_pose", "normal_offset", "eliminated",
                                         "closest_point", "unit_quaternion"));

TEST(Solve, AllLinearSolversFindTheSameMinimum) {
  PlaneWorld world({.noise = 1.0});
  const Graph start = world.Disturbed(0.1, 0.05);
  Graph reference = start;
  SolveOptions options;
  options.linear_solver = LinearSolver::kDenseSchur;
  Solve(&reference, options);
  for (LinearSolver solver : {LinearSolver::kSparseSchur, LinearSolver::kSparseCholesky}) {
    Graph graph = start;
    options.linear_solver = solver;
    EXPECT_TRUE(Solve(&graph, options).converged);
    EXPECT_LT(LargestPoseDifference(graph, reference), 1e-7);
  }
}

TEST(Solve, ChiSquarePerDegreeOfFreedomIsOne) {
  double chi2 = 0.0, degrees = 0.0;
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    PlaneWorld world({.noise = 1.0, .seed = seed});
    Graph graph = world.Disturbed(0.05, 0.02);
    const SolveSummary summary = Solve(&graph);
    chi2 += 2.0 * summary.final_cost;
    degrees += summary.DegreesOfFreedom();
  }
  ASSERT_GT(degrees, 5000);  // one sigma of the mean is then below 2 %
  EXPECT_NEAR(chi2 / degrees, 1.0, 0.05);
}

TEST(Solve, TheWeightOfPairsMakesPosePoseTheLandmarkForm) {
  // Equal qualities, parallel axes: the two forms have the same cost (ALGORITHMS 6.3).
  PlaneWorld world({.poses = 5, .planes = 40, .seen_share = 1.0, .noise = 1.0});
  Graph graph = world.Disturbed(0.0, 0.0);
  for (PlaneLandmark& plane : graph.planes) {
    for (PlaneObservation& seen : plane.observations) {
      seen.tilt_weight_1 = seen.tilt_weight_2 = 300.0;
      seen.offset_weight = 100.0;
    }
  }
  Graph by_pairs = graph;
  const SolveSummary landmarks = Solve(&graph);
  SolveOptions options;
  options.plane_factor = "pose_pose";
  const SolveSummary pairs = Solve(&by_pairs, options);
  // The pairs' covariance adds the lever arm; the costs are alike, not equal.
  EXPECT_NEAR(pairs.final_cost / landmarks.final_cost, 1.0, 0.15);
  EXPECT_LT(LargestPoseDifference(graph, by_pairs), 0.01);
  options.plane_factor_options["count_once"] = 0.0;
  EXPECT_GT(Solve(&by_pairs, options).final_cost, 2.0 * landmarks.final_cost);
}

TEST(Solve, IsRepeatableToTheByte) {
  for (const char* factor : {"moments", "pose_pose"}) {
    PlaneWorld world({.poses = 12, .planes = 200, .noise = 1.0});
    const Graph start = world.Disturbed(0.2, 0.05);
    SolveOptions options;
    options.plane_factor = factor;
    Graph first = start, second = start;
    Solve(&first, options);
    Solve(&second, options);
    for (std::size_t i = 0; i < first.poses.size(); ++i) {
      const Rigid3 &a = first.poses[i].world_from_node, &b = second.poses[i].world_from_node;
      EXPECT_EQ(std::memcmp(a.rotation.coeffs().data(), b.rotation.coeffs().data(), 32), 0);
      EXPECT_EQ(std::memcmp(a.translation.data(), b.translation.data(), 24), 0);
    }
  }
}

TEST(Solve, OrderOfPosesAndPlanesDoesNotMatter) {
  PlaneWorld world({.noise = 1.0});
  Graph graph = world.Disturbed(0.05, 0.02);
  Graph permuted = graph;
  const int n = static_cast<int>(graph.poses.size());
  std::reverse(permuted.poses.begin(), permuted.poses.end());
  std::reverse(permuted.planes.begin(), permuted.planes.end());
  for (PlaneLandmark& plane : permuted.planes) {
    std::reverse(plane.observations.begin(), plane.observations.end());
    for (PlaneObservation& seen : plane.observations) seen.pose = n - 1 - seen.pose;
  }
  SolveOptions options;
  options.function_tolerance = options.parameter_tolerance = options.gradient_tolerance = 1e-14;
  Solve(&graph, options);
  Solve(&permuted, options);
  std::reverse(permuted.poses.begin(), permuted.poses.end());
  EXPECT_LT(LargestPoseDifference(graph, permuted), 1e-9);
}

TEST(Solve, RigidMotionOfTheWorldLeavesTheCost) {
  PlaneWorld world({.noise = 1.0});
  Graph graph = world.truth();
  const auto before = EvaluateResiduals(graph);
  const Rigid3 moved(ExpSO3({0.4, -1.0, 0.7}), {100, -20, 7});
  for (PoseNode& node : graph.poses) node.world_from_node = moved * node.world_from_node;
  for (PlaneLandmark& plane : graph.planes) {
    plane.anchor = moved * plane.anchor;
    plane.normal = moved.rotation * plane.normal;
  }
  const auto after = EvaluateResiduals(graph);
  ASSERT_EQ(before.size(), after.size());
  for (std::size_t k = 0; k < before.size(); ++k) {
    EXPECT_NEAR(after[k].chi2, before[k].chi2, 1e-9 * (1.0 + before[k].chi2));
  }
}

TEST(Solve, UnobservedDirectionKeepsItsStart) {
  PlaneWorld world({.directions = 2});  // no plane across z
  Graph graph = world.truth();
  for (std::size_t i = 1; i < graph.poses.size(); ++i) {
    graph.poses[i].world_from_node.translation += Eigen::Vector3d(0.05, -0.05, 0.5);
  }
  const SolveSummary summary = Solve(&graph);
  EXPECT_TRUE(summary.converged);
  for (std::size_t i = 1; i < graph.poses.size(); ++i) {
    const Eigen::Vector3d error = graph.poses[i].world_from_node.translation -
                                  world.truth().poses[i].world_from_node.translation;
    EXPECT_LT(error.head<2>().norm(), 1e-6);
    EXPECT_NEAR(error.z(), 0.5, 0.05);  // the first steps' tilt moves it a little
  }
}

TEST(Solve, PriorsAndRelativePosesReplaceTheGauge) {
  Graph graph;
  const Rigid3 first(ExpSO3({0.1, 0.2, 3.0}), {5, 6, 7}), step(ExpSO3({0, 0, 0.5}), {1, 0, 0.1});
  graph.poses = {{"a", {}}, {"b", {}}, {"c", {}}};
  graph.pose_factors = {MakePosePrior(0, first, 100.0 * Matrix6d::Identity()),
                        MakeRelativePose(0, 1, step, 10.0 * Matrix6d::Identity(), "odometry"),
                        MakeRelativePose(1, 2, step, 10.0 * Matrix6d::Identity(), "odometry")};
  EXPECT_TRUE(Solve(&graph).converged);
  Graph expected = graph;
  expected.poses[0].world_from_node = first;
  expected.poses[1].world_from_node = first * step;
  expected.poses[2].world_from_node = first * step * step;
  EXPECT_LT(LargestPoseDifference(graph, expected), 1e-8);
}

TEST(Solve, RobustLossSwitchesAWrongObservationOff) {
  PlaneWorld world({.poses = 6, .planes = 60, .seen_share = 0.9});
  Graph graph = world.truth();
  PlaneObservation& wrong = graph.planes[3].observations[1];
  wrong.centroid += 2.0 * wrong.axes.col(0);
  SolveOptions options;
  options.plane_loss = ParseLoss("geman_mcclure");
  const SolveSummary summary = Solve(&graph, options);
  EXPECT_LT(LargestPoseDifference(graph, world.truth()), 1e-4);
  for (const ResidualReport& report : summary.residuals) {
    const bool is_wrong = report.tag.plane == 3 && report.tag.observation == 1;
    EXPECT_EQ(report.weight < 0.01, is_wrong);
  }
}

TEST(Solve, BadInputIsNamed) {
  PlaneWorld world({});
  Graph graph = world.truth();
  SolveOptions options;
  options.plane_factor = "no_such_factor";
  EXPECT_THROW(Solve(&graph, options), UsageError);
  options.plane_factor = "relative_pose";  // of the other kind
  EXPECT_THROW(Solve(&graph, options), UsageError);
  options.plane_factor = "moments";
  options.plane_factor_options["nonsense"] = 1.0;
  EXPECT_THROW(Solve(&graph, options), UsageError);
  graph.planes[0].observations[0].pose = 100;
  EXPECT_THROW(Solve(&graph), std::invalid_argument);
}

TEST(Solve, EmptyGraph) {
  Graph graph;
  EXPECT_NO_THROW(Solve(&graph));
  graph.poses.resize(2);
  EXPECT_NO_THROW(Solve(&graph));
}

}  // namespace
}  // namespace planegraph
