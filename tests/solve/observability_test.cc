#include "planegraph/solve/observability.h"

#include <gtest/gtest.h>

#include <cmath>
#include <set>

#include "planegraph/geometry/rotation.h"
#include "planegraph/solve/covariance.h"
#include "solve/plane_world.h"

namespace planegraph {
namespace {

std::vector<OpenMotion> MotionsOf(const Graph& graph) {
  return GraphCovariance(graph).OpenMotions();
}

std::set<std::set<int>> PartsOf(const OpenMotion& motion) {
  std::set<std::set<int>> parts;
  for (const auto& part : motion.parts) parts.insert({part.begin(), part.end()});
  return parts;
}

// The world moved as a whole.
Graph Moved(Graph graph, const Rigid3& motion) {
  for (PoseNode& node : graph.poses) node.world_from_node = motion * node.world_from_node;
  for (PlaneLandmark& plane : graph.planes) {
    plane.anchor = motion * plane.anchor;
    plane.normal = motion.rotation * plane.normal;
  }
  return graph;
}

// All normals across z: every pose slides along it, which is one motion.
Graph Corridor(int poses) {
  PlaneWorld world({.poses = poses, .planes = 60, .seen_share = 0.9, .directions = 2});
  return world.truth();
}

TEST(OpenMotions, NothingIsOpenInARoom) {
  PlaneWorld world({.poses = 5, .planes = 30, .directions = 3});
  EXPECT_TRUE(MotionsOf(world.truth()).empty());
}

TEST(OpenMotions, ACorridorIsOneMotionOfAllScans) {
  Graph graph = Corridor(6);
  const auto bare = MotionsOf(graph);
  ASSERT_EQ(bare.size(), 1u);
  EXPECT_TRUE(std::isinf(bare[0].sigma));
  EXPECT_EQ(bare[0].held_by, "");
  AddOdometry(0.5, 0.02, &graph);
  const auto motions = MotionsOf(graph);
  ASSERT_EQ(motions.size(), 1u);
  const OpenMotion& motion = motions[0];
  EXPECT_EQ(motion.kind, MotionKind::kTranslation);
  ASSERT_EQ(motion.axes.size(), 1u);
  EXPECT_NEAR(motion.axes[0].z(), 1.0, 1e-9);
  EXPECT_EQ(motion.parts.size(), 6u);
  EXPECT_EQ(motion.degrees_of_freedom, 5);
  EXPECT_TRUE(std::isinf(motion.sigma_planes));
  // The farthest pose from the reference, by a chain of steps of 0.5 m.
  const int steps = std::max(motion.reference, 5 - motion.reference);
  EXPECT_NEAR(motion.sigma, 0.5 * std::sqrt(steps), 0.02);
  EXPECT_EQ(motion.held_by, "odometry");
  EXPECT_EQ(InWords(motion), "translation along (0.00, 0.00, 1.00)");
}

TEST(OpenMotions, DoNotDependOnTheGauge) {
  Graph graph = Corridor(5);
  AddOdometry(0.5, 0.02, &graph);
  const auto by_first = MotionsOf(graph);
  graph.poses[0].fixed = false;
  graph.poses[3].fixed = true;
  const auto by_other = MotionsOf(graph);
  ASSERT_EQ(by_first.size(), 1u);
  ASSERT_EQ(by_other.size(), 1u);
  EXPECT_EQ(PartsOf(by_first[0]), PartsOf(by_other[0]));
  EXPECT_NEAR(by_first[0].sigma, by_other[0].sigma, 1e-6);
  EXPECT_EQ(by_first[0].reference, by_other[0].reference);
}

TEST(OpenMotions, TurnWithTheWorld) {
  Graph graph = Corridor(5);
  AddOdometry(0.5, 0.02, &graph);
  const Rigid3 motion(ExpSO3({0.4, -1.1, 0.7}), {100, -50, 20});
  const auto here = MotionsOf(graph), there = MotionsOf(Moved(graph, motion));
  ASSERT_EQ(there.size(), 1u);
  EXPECT_NEAR(std::abs(there[0].axes[0].dot(motion.rotation * here[0].axes[0])), 1.0, 1e-9);
  EXPECT_EQ(PartsOf(there[0]), PartsOf(here[0]));
  EXPECT_NEAR(there[0].sigma, here[0].sigma, 1e-6);
}

// Better planes leave the same motions open, and odometry alone says how far.
TEST(OpenMotions, DoNotDependOnTheSizeOfTheWeights) {
  Graph graph = Corridor(4);
  AddOdometry(0.5, 0.02, &graph);
  const auto before = MotionsOf(graph);
  for (PlaneLandmark& plane : graph.planes) {
    for (PlaneObservation& seen : plane.observations) {
      seen.tilt_weight_1 *= 10, seen.tilt_weight_2 *= 10, seen.offset_weight *= 10;
    }
  }
  const auto after = MotionsOf(graph);
  ASSERT_EQ(after.size(), before.size());
  EXPECT_EQ(PartsOf(after[0]), PartsOf(before[0]));
  EXPECT_NEAR(after[0].sigma, before[0].sigma, 1e-3);
}

// Two rooms and a corridor between them, of which each room sees the walls alone: the rooms as a
// whole slide against each other, which no pair of scans within them shows.
TEST(OpenMotions, TwoRoomsSlideAsAWhole) {
  PlaneWorld world({.poses = 6, .planes = 90, .seen_share = 1.0, .directions = 3});
  Graph graph = world.truth();
  for (PlaneLandmark& plane : graph.planes) {
    const bool along = std::abs(plane.normal.z()) > 0.5;
    const bool first_room = plane.user_tag % 2 == 0;
    if (!along) continue;
    std::erase_if(plane.observations,
                  [&](const PlaneObservation& seen) { return (seen.pose < 2) != first_room; });
  }
  AddOdometry(0.3, 0.02, &graph);
  const auto motions = MotionsOf(graph);
  ASSERT_EQ(motions.size(), 1u);
  EXPECT_NEAR(std::abs(motions[0].axes[0].z()), 1.0, 1e-6);
  EXPECT_EQ(PartsOf(motions[0]), (std::set<std::set<int>>{{0, 1}, {2, 3, 4, 5}}));
  EXPECT_EQ(motions[0].parts[0].size(), 4u);  // the rest comes first
  EXPECT_EQ(motions[0].degrees_of_freedom, 1);
  EXPECT_NEAR(motions[0].sigma, 0.3, 0.01);
}

// One direction of normals (x): two translations and a rotation.
TEST(OpenMotions, AFieldLeavesThreeOpen) {
  PlaneWorld world({.poses = 4, .planes = 30, .seen_share = 0.9, .directions = 1});
  const auto motions = MotionsOf(world.truth());
  ASSERT_EQ(motions.size(), 2u);
  EXPECT_EQ(motions[0].kind, MotionKind::kTranslation);
  ASSERT_EQ(motions[0].axes.size(), 2u);
  EXPECT_NEAR(std::abs(motions[0].axes[0].cross(motions[0].axes[1]).x()), 1.0, 1e-6);
  EXPECT_EQ(motions[1].kind, MotionKind::kRotation);
  ASSERT_EQ(motions[1].axes.size(), 1u);
  EXPECT_NEAR(std::abs(motions[1].axes[0].x()), 1.0, 1e-6);
  EXPECT_EQ(motions[0].degrees_of_freedom + motions[1].degrees_of_freedom, 9);
}

TEST(OpenMotions, ScansWithoutCommonPlanes) {
  PlaneWorld world({.poses = 3, .planes = 30});
  Graph graph = world.truth();
  graph.poses.push_back({"alone", Rigid3()});
  const auto motions = MotionsOf(graph);
  ASSERT_EQ(motions.size(), 1u);
  EXPECT_EQ(motions[0].kind, MotionKind::kEverything);
  EXPECT_EQ(PartsOf(motions[0]), (std::set<std::set<int>>{{0, 1, 2}, {3}}));
  EXPECT_EQ(motions[0].degrees_of_freedom, 6);
}

}  // namespace
}  // namespace planegraph
