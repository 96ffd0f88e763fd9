#include "planegraph/solve/joint_initialization.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>

#include "planegraph/solve/solver.h"
#include "solve/mismatched_graph.h"
#include "solve/plane_world.h"

namespace planegraph {
namespace {

Graph WithRandomPoses(const Graph& truth, std::mt19937_64* rng) {
  Graph graph = truth;
  ScatterPoses(20.0, rng, &graph);
  return graph;
}

TEST(JointInitialization, ExactFromNoGuess) {
  PlaneWorld world({.poses = 8, .planes = 60, .seed = 4});
  Graph graph = WithRandomPoses(world.truth(), &world.rng());
  const JointInitialization result = InitializeJointly(&graph);
  EXPECT_TRUE(result.one_component);
  EXPECT_LT(LargestPoseDifference(graph, world.truth()), 1e-6);
  for (std::size_t k = 0; k < graph.planes.size(); ++k) {
    if (graph.planes[k].observations.size() < 2) continue;
    EXPECT_GT(graph.planes[k].normal.dot(world.truth().planes[k].normal), 1.0 - 1e-9);
    EXPECT_THAT(result.agreeing[k], testing::Each(true));
  }
}

TEST(JointInitialization, AsGoodAsTheNoiseAllows) {
  for (std::uint64_t seed = 1; seed <= 10; ++seed) {
    PlaneWorld world({.poses = 8, .planes = 60, .noise = 1.0, .seed = seed});
    Graph optimum = world.truth();
    Solve(&optimum);
    Graph graph = WithRandomPoses(world.truth(), &world.rng());
    InitializeJointly(&graph);
    // The closed form takes rotations from normals alone: some 36 of them with 3 mrad give 0.6
    // mrad, which at up to 25 m are 15 mm for one sigma; there are 42 numbers in all.
    EXPECT_LT(LargestPoseDifference(graph, optimum), 0.05) << "seed " << seed;
    EXPECT_TRUE(Solve(&graph).converged);
    EXPECT_LT(LargestPoseDifference(graph, optimum), 1e-6) << "seed " << seed;
  }
}

TEST(JointInitialization, ThreeInFiveMismatched) {
  int right = 0;
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    PlaneWorld world({.poses = 8, .planes = 150, .noise = 1.0, .seed = seed});
    Graph graph = WithRandomPoses(world.truth(), &world.rng());
    MismatchObservations(0.6, &world.rng(), &graph);
    InitializeJointly(&graph);
    right += LargestPoseDifference(graph, world.truth()) < 0.05;
  }
  EXPECT_GE(right, 19);
}

TEST(JointInitialization, EquivariantUnderMotionsOfTheWorld) {
  PlaneWorld world({.poses = 6, .planes = 60, .noise = 1.0, .seed = 8});
  Graph graph = WithRandomPoses(world.truth(), &world.rng());
  Graph moved = graph;
  const Rigid3 motion(ExpSO3({0.4, -1.2, 2.0}), {5.0, -3.0, 1.0});
  moved.poses[0].world_from_node = motion * moved.poses[0].world_from_node;
  InitializeJointly(&graph);
  InitializeJointly(&moved);
  for (PoseNode& node : graph.poses) node.world_from_node = motion * node.world_from_node;
  EXPECT_LT(LargestPoseDifference(graph, moved), 1e-6);
}

TEST(JointInitialization, UnrelatedPartsAreComponents) {
  PlaneWorld a({.poses = 4, .planes = 60, .seed = 1}), b({.poses = 4, .planes = 60, .seed = 2});
  Graph graph = a.truth();
  Graph other = b.truth();
  other.poses[0].fixed = false;
  for (PoseNode& node : other.poses) graph.poses.push_back(node);
  for (PlaneLandmark& plane : other.planes) {
    for (PlaneObservation& seen : plane.observations) seen.pose += 4;
    graph.planes.push_back(plane);
  }
  const JointInitialization result = InitializeJointly(&graph);
  EXPECT_FALSE(result.one_component);
  EXPECT_THAT(result.pose_component, testing::ElementsAre(0, 0, 0, 0, 4, 4, 4, 4));
}

TEST(JointInitialization, AScanWithoutPlanesHangsOnItsOdometry) {
  PlaneWorld world({.poses = 5, .planes = 60, .seed = 3});
  Graph graph = world.truth();
  const Rigid3 step(ExpSO3({0.0, 0.0, 0.5}), {2.0, 0.0, 0.0});
  graph.poses.push_back({"blind", Rigid3()});
  graph.pose_factors.push_back(MakeRelativePose(4, 5, step, Matrix6d::Identity(), "odometry"));
  Graph start = WithRandomPoses(graph, &world.rng());
  InitializeJointly(&start);
  graph.poses[5].world_from_node = graph.poses[4].world_from_node * step;
  EXPECT_LT(LargestPoseDifference(start, graph), 1e-6);
}

// A drone map of another scale, seen as one more node.
TEST(JointInitialization, FindsTheScaleOfAMap) {
  PlaneWorld world({.poses = 6, .planes = 80, .noise = 1.0, .seed = 5});
  Graph truth = world.truth();
  const Sim3 world_from_map(3.7, ExpSO3({1.0, 2.0, -0.5}), {10.0, -4.0, 2.0});
  truth.maps.push_back({"drone", world_from_map});
  const Sim3 map_from_world = world_from_map.Inverse();
  for (PlaneLandmark& plane : truth.planes) {
    PlaneObservation seen;
    seen.map = 0;
    seen.centroid = map_from_world * (plane.anchor + plane.offset * plane.normal);
    const auto basis = TangentBasis(plane.normal);
    seen.axes << plane.normal, basis;
    seen.axes = map_from_world.rotation.toRotationMatrix() * seen.axes;
    seen.tilt_weight_1 = seen.tilt_weight_2 = 100.0;
    seen.offset_weight = 50.0;
    plane.observations.push_back(seen);
  }
  Graph graph = WithRandomPoses(truth, &world.rng());
  graph.maps[0].world_from_map = Sim3();
  InitializeJointly(&graph);
  EXPECT_NEAR(graph.maps[0].world_from_map.scale / 3.7, 1.0, 0.005);
  EXPECT_LT(AngleBetween(graph.maps[0].world_from_map.rotation, world_from_map.rotation), 0.01);
  EXPECT_LT(LargestPoseDifference(graph, truth), 0.03);
}

TEST(JointInitialization, EmptyGraphAndGraphsWithoutPlanes) {
  Graph empty;
  EXPECT_TRUE(InitializeJointly(&empty).one_component);
  Graph one;
  one.poses.push_back({"a", Rigid3()});
  EXPECT_TRUE(InitializeJointly(&one).one_component);
}

}  // namespace
}  // namespace planegraph
