#include "planegraph/solve/marginal_graph.h"

#include <gtest/gtest.h>

#include <Eigen/Dense>

#include "planegraph/geometry/rotation.h"
#include "planegraph/graph/factor_sampling.h"
#include "planegraph/solve/covariance.h"
#include "solve/plane_world.h"

namespace planegraph {
namespace {

std::vector<std::pair<int, int>> AllPairs(int count) {
  std::vector<std::pair<int, int>> pairs;
  for (int i = 0; i < count; ++i) {
    for (int j = i + 1; j < count; ++j) pairs.emplace_back(i, j);
  }
  return pairs;
}

Graph PoseGraph(const Graph& graph, const std::vector<MarginalEdge>& edges) {
  Graph poses;
  poses.poses = graph.poses;
  for (const MarginalEdge& edge : edges) {
    poses.pose_factors.push_back(MakeRelativePose(edge.target, edge.source, edge.target_from_source,
                                                  edge.information, "planes"));
  }
  return poses;
}

TEST(MarginalEdges, KeepTheOptimum) {
  PlaneWorld world({.poses = 6, .planes = 60, .noise = 1.0});
  Graph graph = world.Disturbed(0.05, 0.02);
  Solve(&graph);
  const Graph optimum = PoseGraph(graph, MarginalEdges(graph, AllPairs(6)));
  Graph poses = optimum;
  for (std::size_t i = 1; i < poses.poses.size(); ++i) {
    Rigid3& pose = poses.poses[i].world_from_node;
    pose = {(ExpSO3(0.05 * world.Vector()) * pose.rotation).normalized(),
            pose.translation + 0.1 * world.Vector()};
  }
  ASSERT_GT(LargestPoseDifference(poses, optimum), 0.05);
  EXPECT_TRUE(Solve(&poses).converged);
  EXPECT_LT(LargestPoseDifference(poses, optimum), 1e-7);
}

TEST(MarginalEdges, OfTwoPosesSayExactlyWhatTheGraphSays) {
  PlaneWorld world({.poses = 2, .planes = 20, .seen_share = 1.0});
  Graph graph = world.truth();
  graph.pose_factors.push_back(MakeRelativePose(
      1, 0, graph.poses[1].world_from_node.Inverse() * graph.poses[0].world_from_node,
      1e3 * Matrix6d::Identity(), "odometry"));
  for (const std::pair<int, int>& pair : {std::pair(0, 1), std::pair(1, 0)}) {
    const Matrix6d expected = GraphCovariance(graph).Relative(pair.first, pair.second).inverse();
    const Matrix6d found = MarginalEdges(graph, {pair})[0].information;
    EXPECT_LT((found - expected).norm(), 1e-7 * expected.norm()) << pair.first;
  }
}

TEST(MarginalEdges, CountAPlaneOnce) {
  // Equal qualities and centroids: the pose graph of all pairs is exactly as sure as the graph
  // itself. (Where the centroids lie apart a pair loses the offsets' share in the tilt: less sure,
  // never more.)
  PlaneWorld world({.poses = 5, .planes = 60, .seen_share = 1.0});
  Graph graph = world.truth();
  for (PlaneLandmark& plane : graph.planes) {
    for (PlaneObservation& seen : plane.observations) {
      seen.tilt_weight_1 = seen.tilt_weight_2 = seen.offset_weight = 200.0;
      seen.centroid = graph.poses[seen.pose].world_from_node.Inverse() *
                      (plane.anchor + plane.offset * plane.normal);
    }
  }
  const Matrix6d by_planes = GraphCovariance(graph).Pose(3);
  const Matrix6d by_pairs =
      GraphCovariance(PoseGraph(graph, MarginalEdges(graph, AllPairs(5)))).Pose(3);
  const Vector6d ratio = by_pairs.diagonal().cwiseQuotient(by_planes.diagonal());
  EXPECT_NEAR(ratio.minCoeff(), 1.0, 1e-6);
  EXPECT_NEAR(ratio.maxCoeff(), 1.0, 1e-6);
}

TEST(MarginalEdges, APairWithoutCommonPlanesHasNoInformation) {
  PlaneWorld world({.poses = 3});
  Graph graph = world.truth();
  for (PlaneLandmark& plane : graph.planes) {
    std::erase_if(plane.observations, [](const PlaneObservation& seen) { return seen.pose == 2; });
  }
  EXPECT_EQ(MarginalEdges(graph, {{0, 2}})[0].information.norm(), 0.0);
}

// g2o's error of EDGE_SE3:QUAT: translation and vector part of Z^-1 X_t^-1 X_s.
Vector6d G2oError(const Rigid3& measurement, const Rigid3& target_from_source) {
  const Rigid3 delta = measurement.Inverse() * target_from_source;
  Vector6d error;
  const double sign = delta.rotation.w() < 0.0 ? -1.0 : 1.0;
  error << delta.translation, sign * delta.rotation.vec();
  return error;
}

TEST(G2oInformation, HasTheSameCostInTheHalfAngleConvention) {
  std::mt19937_64 rng(5);
  for (int trial = 0; trial < 50; ++trial) {
    FactorSampler sampler(&rng);
    const Rigid3 measurement = sampler.Pose();
    const Matrix6d information = sampler.Information();
    Vector6d step;
    for (int k = 0; k < 6; ++k) step[k] = 1e-5 * sampler.Uniform(-1, 1);
    const Rigid3 moved(ExpSO3(step.tail<3>()) * measurement.rotation,
                       measurement.translation + step.head<3>());
    const Vector6d error = G2oError(measurement, moved);
    const double expected = step.dot(information * step);
    EXPECT_NEAR(error.dot(G2oInformation(measurement, information) * error), expected,
                1e-6 * information.norm() * step.squaredNorm());
    EXPECT_LT(
        (InformationFromG2o(measurement, G2oInformation(measurement, information)) - information)
            .norm(),
        1e-9 * information.norm());
  }
}

TEST(G2oInformation, ScalesRotationsByFourAndCrossBlocksByTwo) {
  Matrix6d information = Matrix6d::Ones() + 6.0 * Matrix6d::Identity();
  const Matrix6d omega = G2oInformation(Rigid3(), information);
  EXPECT_LT((omega.topLeftCorner<3, 3>() - information.topLeftCorner<3, 3>()).norm(), 1e-12);
  EXPECT_LT((omega.topRightCorner<3, 3>() - 2.0 * information.topRightCorner<3, 3>()).norm(),
            1e-12);
  EXPECT_LT((omega.bottomRightCorner<3, 3>() - 4.0 * information.bottomRightCorner<3, 3>()).norm(),
            1e-12);
}

}  // namespace
}  // namespace planegraph
