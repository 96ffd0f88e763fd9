// Covariances and gauge of graphs with drone maps.
#include <gtest/gtest.h>

#include <Eigen/Dense>

#include "planegraph/solve/covariance.h"
#include "planegraph/solve/solver.h"
#include "solve/information.h"
#include "solve/plane_world.h"

namespace planegraph {
namespace {

// A world of planes of which a map sees every second one.
Graph WorldWithMap(std::uint64_t seed, const Sim3& world_from_map) {
  PlaneWorld world({.poses = 3, .planes = 30, .seen_share = 0.8, .seed = seed});
  Graph graph = world.truth();
  graph.maps.push_back({"map", world_from_map});
  for (std::size_t k = 0; k < graph.planes.size(); k += 2) {
    PlaneLandmark& plane = graph.planes[k];
    PlaneObservation seen;
    seen.map = 0;
    const Sim3 map_from_world = world_from_map.Inverse();
    const auto basis = TangentBasis(plane.normal);
    Eigen::Matrix3d axes;
    axes << plane.normal, basis;
    seen.centroid = map_from_world * (plane.anchor + plane.offset * plane.normal +
                                      basis * Eigen::Vector2d(world.Normal(), world.Normal()));
    seen.axes = map_from_world.rotation.toRotationMatrix() * axes;
    seen.tilt_weight_1 = 60.0, seen.tilt_weight_2 = 90.0, seen.offset_weight = 20.0;
    seen.point_count = 50;
    plane.observations.push_back(seen);
  }
  return graph;
}

const Sim3 kMap(7.0, ExpSO3({0.5, -1.0, 0.3}), {3, -2, 1});

// The information of all poses, maps and planes as one dense matrix, what is fixed left out.
Eigen::MatrixXd DenseInformation(const Graph& graph) {
  const int poses = static_cast<int>(graph.poses.size()),
            maps = static_cast<int>(graph.maps.size());
  const int first_plane = 6 * poses + 7 * maps;
  const int rows = first_plane + 3 * static_cast<int>(graph.planes.size());
  Eigen::MatrixXd information = Eigen::MatrixXd::Zero(rows, rows);
  const auto row_of = [&](const BlockRef& b) {
    if (b.kind == BlockKind::kPlane) return first_plane + 3 * b.index;
    return b.kind == BlockKind::kMap ? 6 * poses + 7 * b.index : 6 * b.index;
  };
  const auto add = [&](const auto& blocks, const auto& jacobians) {
    for (std::size_t a = 0; a < blocks.size(); ++a) {
      for (std::size_t b = 0; b < blocks.size(); ++b) {
        information.block(row_of(blocks[a]), row_of(blocks[b]), jacobians[a].cols(),
                          jacobians[b].cols()) += jacobians[a].transpose() * jacobians[b];
      }
    }
  };
  const LinearizedGraph linear = LinearizeGraph(graph, {});
  for (const auto& plane : linear.planes) {
    for (const auto& r : plane) add(r.blocks, r.linear.jacobians);
  }
  for (const auto& f : linear.pose_factors) add(f.blocks, f.jacobians);
  return information;
}

// Its pseudo-inverse with the first pose held.
Eigen::MatrixXd DenseCovariance(const Graph& graph) {
  Eigen::MatrixXd information = DenseInformation(graph);
  information.topRows<6>().setZero();
  information.leftCols<6>().setZero();
  return information.completeOrthogonalDecomposition().pseudoInverse();
}

TEST(MapCovariance, OfAMapThatNothingHoldsIsUnknown) {
  Graph graph = WorldWithMap(1, kMap);
  graph.maps.push_back({"alone", kMap});
  const GraphCovariance covariance(graph);
  EXPECT_TRUE(covariance.Map(0).allFinite());
  EXPECT_TRUE(covariance.Map(1).array().isNaN().all());
}

TEST(MapCovariance, IsThatOfTheDensePseudoInverse) {
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    const Graph graph = WorldWithMap(seed, kMap);
    const GraphCovariance covariance(graph);
    const Eigen::MatrixXd dense = DenseCovariance(graph);
    const Matrix7d expected = dense.block<7, 7>(6 * 3, 6 * 3);
    ASSERT_GT(expected.diagonal().minCoeff(), 0.0);
    const Vector7d sigmas = expected.diagonal().cwiseSqrt();
    const Matrix7d difference = covariance.Map(0) - expected;
    for (int a = 0; a < 7; ++a) {
      for (int b = 0; b < 7; ++b) {
        EXPECT_LT(std::abs(difference(a, b)), 1e-6 * sigmas[a] * sigmas[b]) << a << " " << b;
      }
    }
    const Matrix6d pose = dense.block<6, 6>(6 * 2, 6 * 2);
    EXPECT_LT((covariance.Pose(2) - pose).norm(), 1e-6 * pose.norm());
  }
}

TEST(MapCovariance, AFixedMapHasNone) {
  Graph graph = WorldWithMap(1, kMap);
  graph.maps[0].fixed = true;
  EXPECT_EQ(GraphCovariance(graph).Map(0).norm(), 0.0);
}

TEST(MapCovariance, CamerasLowerIt) {
  Graph graph = WorldWithMap(2, kMap);
  const Matrix7d before = GraphCovariance(graph).Map(0);
  for (int k = 0; k < 6; ++k) {
    MapFactor factor;
    factor.maps = {0};
    factor.point = 2.0 * Eigen::Vector3d(std::cos(k), std::sin(k), 0.1 * k);
    factor.position = kMap * factor.point;
    factor.information.setIdentity();
    graph.map_factors.push_back(factor);
  }
  const Matrix7d after = GraphCovariance(graph).Map(0);
  const Eigen::SelfAdjointEigenSolver<Matrix7d> solver(before - after);
  EXPECT_GT(solver.eigenvalues().minCoeff(), -1e-9 * before.norm());
  EXPECT_LT(after.trace(), before.trace());
}

TEST(MapCovariance, DoesNotDependOnTheMapsUnit) {
  // The same map in units ten times as long: log(scale) and the pose have the same errors.
  const Sim3 longer(10.0 * kMap.scale, kMap.rotation, kMap.translation);
  const Matrix7d a = GraphCovariance(WorldWithMap(3, kMap)).Map(0);
  const Matrix7d b = GraphCovariance(WorldWithMap(3, longer)).Map(0);
  EXPECT_LT((a - b).norm(), 1e-9 * a.norm());
}

// Poses and maps may be held by positions of cameras alone.
TEST(Gauge, CamerasHoldTheWorld) {
  Graph graph = WorldWithMap(4, kMap);
  graph.poses[0].fixed = false;
  for (int k = 0; k < 8; ++k) {
    MapFactor factor;
    factor.maps = {0};
    factor.point = 3.0 * Eigen::Vector3d(std::cos(k), std::sin(k), 0.2 * k);
    factor.position = kMap * factor.point;
    factor.information = 100.0 * Matrix7d::Identity();
    graph.map_factors.push_back(factor);
  }
  const Graph truth = graph;
  const Rigid3 motion(ExpSO3({0.02, -0.01, 0.03}), {0.4, -0.3, 0.2});
  for (PoseNode& node : graph.poses) node.world_from_node = motion * node.world_from_node;
  graph.maps[0].world_from_map = Sim3(motion) * graph.maps[0].world_from_map;
  for (PlaneLandmark& plane : graph.planes) {
    plane.normal = motion.rotation * plane.normal;
    plane.anchor = motion * plane.anchor;
  }
  SolveOptions options;
  options.initial_radius = 1e8;
  const SolveSummary summary = Solve(&graph, options);
  EXPECT_TRUE(summary.usable);
  EXPECT_LT(LargestPoseDifference(graph, truth), 1e-5);
  EXPECT_NEAR(graph.maps[0].world_from_map.scale / kMap.scale, 1.0, 1e-6);
}

TEST(Gauge, WithoutPriorsTheFirstPoseStays) {
  Graph graph = WorldWithMap(5, kMap);
  graph.poses[0].fixed = false;
  const Rigid3 first = graph.poses[0].world_from_node;
  graph.poses[1].world_from_node.translation += Eigen::Vector3d(0.1, 0.1, 0.1);
  graph.maps[0].world_from_map.scale *= 1.02;
  Solve(&graph);
  EXPECT_EQ(graph.poses[0].world_from_node.translation, first.translation);
  EXPECT_NEAR(graph.maps[0].world_from_map.scale / kMap.scale, 1.0, 1e-6);
}

TEST(Solve, AFixedMapStaysAndHoldsTheScans) {
  Graph graph = WorldWithMap(6, kMap);
  const Graph truth = graph;
  graph.poses[0].fixed = false;
  graph.maps[0].fixed = true;
  for (PoseNode& node : graph.poses) node.world_from_node.translation.x() += 0.2;
  Solve(&graph);
  EXPECT_DOUBLE_EQ(graph.maps[0].world_from_map.scale, kMap.scale);
  EXPECT_EQ(graph.maps[0].world_from_map.translation, kMap.translation);
  EXPECT_LT(LargestPoseDifference(graph, truth), 1e-6);
}

}  // namespace
}  // namespace planegraph
