// Graduated non-convexity in the solver.
#include <gtest/gtest.h>

#include <set>

#include "planegraph/solve/solver.h"
#include "solve/plane_world.h"

namespace planegraph {
namespace {

SolveOptions Graduated(const std::string& loss, const std::string& factor = "moments") {
  SolveOptions options;
  options.plane_factor = factor;
  options.plane_loss = ParseLoss(loss);
  return options;
}

// Every third observation lies metres off.
std::set<std::pair<int, int>> Spoil(PlaneWorld* world, Graph* graph) {
  std::set<std::pair<int, int>> wrong;
  for (int k = 0; k < static_cast<int>(graph->planes.size()); ++k) {
    auto& seen = graph->planes[k].observations;
    if (seen.size() < 4) continue;
    PlaneObservation& spoilt = seen[k % seen.size()];
    spoilt.centroid += (1.0 + std::abs(world->Normal())) * spoilt.axes.col(0);
    wrong.insert({k, k % static_cast<int>(seen.size())});
  }
  return wrong;
}

class GraduatedLoss : public testing::TestWithParam<const char*> {};

TEST_P(GraduatedLoss, SwitchesOffWhatIsWrongAndNothingElse) {
  PlaneWorld world({.poses = 8, .planes = 60, .seen_share = 0.8, .noise = 0.3});
  Graph clean = world.truth();
  Solve(&clean);
  Graph graph = world.Disturbed(0.3, 0.1);
  const auto wrong = Spoil(&world, &graph);
  ASSERT_GT(wrong.size(), 50u);
  const SolveSummary summary = Solve(&graph, Graduated(GetParam()));
  EXPECT_TRUE(summary.converged);
  EXPECT_GT(summary.graduated_steps, 5);
  EXPECT_LT(LargestPoseDifference(graph, clean), 0.01);
  for (const ResidualReport& report : summary.residuals) {
    const bool is_wrong = wrong.count({report.tag.plane, report.tag.observation}) > 0;
    EXPECT_EQ(report.weight < 0.1, is_wrong) << report.tag.plane << " " << report.chi2;
  }
}
INSTANTIATE_TEST_SUITE_P(Kernels, GraduatedLoss, testing::Values("gnc_tls", "gnc_gm"));

TEST(GraduatedSolve, WithoutOutliersIsTheSolveWithoutLoss) {
  PlaneWorld world({.poses = 6, .planes = 40, .noise = 0.3});
  Graph plain = world.Disturbed(0.1, 0.05), graduated = plain;
  Solve(&plain);
  Solve(&graduated, Graduated("gnc_tls"));
  EXPECT_LT(LargestPoseDifference(plain, graduated), 1e-8);
}

// Half of what a scan saw, as of a wrong place: as single ones, the right half could as well be the
// wrong one. But that a group is wrong is one event, and its chi2 that of all of its degrees of
// freedom, much nearer to their number than that of a single observation: to switch off the group
// costs a third of what it costs to switch off all others.
TEST(GraduatedSolve, AGroupIsSwitchedAsOne) {
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    PlaneWorld world({.poses = 6, .planes = 60, .seen_share = 0.9, .seed = seed});
    Graph graph = world.truth();
    int members = 0, others = 0;
    for (PlaneLandmark& plane : graph.planes) {
      for (PlaneObservation& seen : plane.observations) {
        if (seen.pose != 4) continue;
        if (members > others) {
          ++others;
          continue;
        }
        seen.group = 7;
        seen.centroid += Eigen::Vector3d(0.8, 0.5, -0.6);
        ++members;
      }
    }
    ASSERT_GE(members, others);
    ASSERT_GT(members, 20);
    const SolveSummary summary = Solve(&graph, Graduated("gnc_tls"));
    EXPECT_LT(LargestPoseDifference(graph, world.truth()), 1e-6) << seed;
    for (const ResidualReport& report : summary.residuals) {
      const auto& seen = graph.planes[report.tag.plane].observations[report.tag.observation];
      EXPECT_EQ(report.weight, seen.group == 7 ? 0.0 : 1.0);
    }
  }
}

// One wrong plane does not condemn its registration, nor does it pull at it.
TEST_P(GraduatedLoss, WithinAGroupThatIsRightWrongOnesAreOffAlone) {
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    PlaneWorld world({.poses = 6, .planes = 60, .seen_share = 0.9, .noise = 0.3, .seed = seed});
    Graph clean = world.truth();
    Solve(&clean);
    Graph graph = world.truth();
    std::set<std::pair<int, int>> wrong;
    int members = 0;
    for (int k = 0; k < static_cast<int>(graph.planes.size()); ++k) {
      auto& observations = graph.planes[k].observations;
      for (int j = 0; j < static_cast<int>(observations.size()); ++j) {
        PlaneObservation& seen = observations[j];
        if (seen.pose != 4) continue;
        seen.group = 7;
        if (++members % 4 != 0 || observations.size() < 4) continue;
        seen.centroid += 1.5 * seen.axes.col(0);
        wrong.insert({k, j});
      }
    }
    ASSERT_GT(wrong.size(), 5u);
    const SolveSummary summary = Solve(&graph, Graduated(GetParam()));
    EXPECT_LT(LargestPoseDifference(graph, clean), 0.01) << seed;
    for (const ResidualReport& report : summary.residuals) {
      const bool is_wrong = wrong.count({report.tag.plane, report.tag.observation}) > 0;
      EXPECT_EQ(report.weight < 0.1, is_wrong) << report.chi2;
    }
  }
}

TEST(GraduatedSolve, FalseRelativePosesAreSwitchedOffWithTheirGroups) {
  Graph graph;
  const Rigid3 step(ExpSO3({0, 0, 0.2}), {1, 0, 0});
  Rigid3 pose;
  for (int i = 0; i < 20; ++i, pose = pose * step) {
    graph.poses.push_back({"", pose, i == 0});
    if (i > 0) {
      graph.pose_factors.push_back(
          MakeRelativePose(i - 1, i, step, 1e4 * Matrix6d::Identity(), "odometry"));
    }
  }
  const Graph truth = graph;
  for (int k = 0; k < 8; ++k) {  // true closures, and false ones
    const int target = k, source = k + 10;
    Rigid3 closure =
        truth.poses[target].world_from_node.Inverse() * truth.poses[source].world_from_node;
    if (k % 2 == 1) closure = Rigid3(ExpSO3({0, 0, 1.0}), {5, -3, 1}) * closure;
    graph.pose_factors.push_back(
        MakeRelativePose(target, source, closure, 1e4 * Matrix6d::Identity(), "closure"));
    graph.pose_factors.back().robust = true;
    graph.pose_factors.back().group = k;
  }
  SolveOptions options;
  options.pose_loss = ParseLoss("gnc_tls");
  const SolveSummary summary = Solve(&graph, options);
  EXPECT_LT(LargestPoseDifference(graph, truth), 1e-6);
  for (const ResidualReport& report : summary.residuals) {
    const int k = report.tag.pose_factor - 19;
    EXPECT_EQ(report.weight, k >= 0 && k % 2 == 1 ? 0.0 : 1.0);
  }
}

TEST(GraduatedSolve, WorksWithPlanesEliminated) {
  PlaneWorld world({.poses = 8, .planes = 60, .seen_share = 0.8, .noise = 0.3});
  Graph graph = world.truth();
  for (int k = 0; k < 10; ++k) {
    auto& seen = graph.planes[k].observations.front();
    seen.centroid += 2.0 * seen.axes.col(0);
  }
  const SolveSummary summary = Solve(&graph, Graduated("gnc_tls", "eliminated"));
  EXPECT_LT(LargestPoseDifference(graph, world.truth()), 0.02);
  for (const ResidualReport& report : summary.residuals) {
    EXPECT_EQ(report.weight == 0.0, report.tag.plane < 10);
  }
}

}  // namespace
}  // namespace planegraph
