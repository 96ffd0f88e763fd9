#include "planegraph/pose_graph/optimization.h"

#include <ceres/ceres.h>
#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <numeric>

#include "planegraph/pose_graph/robust_optimization.h"
#include "pose_graph/graphs.h"

namespace planegraph {
namespace {

template <int Dim>
void Scramble(PoseGraph<Dim>* graph, std::uint64_t seed) {
  std::mt19937_64 rng(seed);
  for (std::size_t i = 1; i < graph->poses.size(); ++i) graph->poses[i] = RandomPose<Dim>(&rng);
}

TEST(InitializeChordal, FindsExactPosesFromAnyStart) {
  PoseGraph3 space = NoisyGraph<3>(30, 0.0, 0.0, 1);
  const auto truth3 = space.poses;
  Scramble(&space, 2);
  InitializeChordal(&space);
  EXPECT_LT(LargestDifference(space.poses, truth3), 1e-8);
  PoseGraph2 plane = NoisyGraph<2>(30, 0.0, 0.0, 1);
  const auto truth2 = plane.poses;
  Scramble(&plane, 2);
  InitializeChordal(&plane);
  EXPECT_LT(LargestDifference(plane.poses, truth2), 1e-8);
}

// The same residual in Ceres by automatic differentiation.
struct CeresEdge {
  GraphEdge<3> edge;
  template <typename T>
  bool operator()(const T* a, const T* b, T* out) const {
    using Quaternion = Eigen::Quaternion<T>;
    using Vector3 = Eigen::Matrix<T, 3, 1>;
    const Eigen::Map<const Quaternion> qa(a), qb(b);
    const Eigen::Map<const Vector3> ta(a + 4), tb(b + 4);
    const Quaternion z = Eigen::Quaterniond(edge.measurement.rotation).cast<T>();
    Quaternion e = z.conjugate() * (qa.conjugate() * qb);
    Eigen::Matrix<T, 6, 1> r;
    r.template head<3>() =
        z.conjugate() * (qa.conjugate() * (tb - ta) - edge.measurement.translation.cast<T>());
    r.template tail<3>() = e.w() < T(0) ? Vector3(-e.vec()) : Vector3(e.vec());
    const Eigen::Matrix<double, 6, 6> root = edge.information.llt().matrixU();
    Eigen::Map<Eigen::Matrix<T, 6, 1>> result(out);
    result = root.cast<T>() * r;
    return true;
  }
};

std::vector<GraphPose<3>> SolveByCeres(const PoseGraph3& graph) {
  std::vector<Eigen::Matrix<double, 7, 1>> blocks(graph.poses.size());
  ceres::Problem problem;
  ceres::ProductManifold<ceres::EigenQuaternionManifold, ceres::EuclideanManifold<3>> manifold;
  ceres::Problem::Options options;
  for (std::size_t i = 0; i < blocks.size(); ++i) {
    blocks[i] << Eigen::Quaterniond(graph.poses[i].rotation).coeffs(), graph.poses[i].translation;
    problem.AddParameterBlock(
        blocks[i].data(), 7,
        new ceres::ProductManifold<ceres::EigenQuaternionManifold, ceres::EuclideanManifold<3>>());
  }
  problem.SetParameterBlockConstant(blocks[0].data());
  for (const GraphEdge<3>& edge : graph.edges) {
    problem.AddResidualBlock(
        new ceres::AutoDiffCostFunction<CeresEdge, 6, 7, 7>(new CeresEdge{edge}), nullptr,
        blocks[edge.from].data(), blocks[edge.to].data());
  }
  ceres::Solver::Options solver;
  solver.linear_solver_type = ceres::SPARSE_NORMAL_CHOLESKY;
  solver.function_tolerance = solver.parameter_tolerance = solver.gradient_tolerance = 1e-14;
  solver.max_num_iterations = 200;
  ceres::Solver::Summary summary;
  ceres::Solve(solver, &problem, &summary);
  std::vector<GraphPose<3>> poses;
  for (const auto& block : blocks) {
    poses.push_back({Eigen::Quaterniond(block.data()).toRotationMatrix(), block.tail<3>()});
  }
  return poses;
}

TEST(OptimizePoseGraph, AgreesWithCeresOnFullInformation) {
  PoseGraph3 graph = NoisyGraph<3>(40, 0.1, 0.05, 4);
  std::mt19937_64 rng(5);
  for (GraphEdge<3>& edge : graph.edges) edge.information = RandomInformation<3>(&rng);
  const auto expected = SolveByCeres(graph);
  const PoseGraphSummary summary = OptimizePoseGraph(&graph);
  EXPECT_TRUE(summary.converged);
  EXPECT_LT(LargestDifference(graph.poses, expected), 1e-6);
}

template <int Dim>
void ExpectGaugeFreedom() {
  PoseGraph<Dim> graph = NoisyGraph<Dim>(30, 0.1, 0.05, 6), moved = graph;
  std::mt19937_64 rng(7);
  const GraphPose<Dim> shift = RandomPose<Dim>(&rng);
  for (auto& pose : moved.poses) pose = Compose(shift, pose);
  EXPECT_NEAR(GraphCost(graph), GraphCost(moved), 1e-9 * GraphCost(graph));
  OptimizePoseGraph(&graph);
  OptimizePoseGraph(&moved);
  EXPECT_LT(LargestDifference(graph.poses, moved.poses), 1e-8);
  EXPECT_LT((moved.poses[0].translation - shift.translation).norm(), 1e-12);  // the first one stays
}

TEST(OptimizePoseGraph, ResultDoesNotDependOnTheGauge) {
  ExpectGaugeFreedom<2>();
  ExpectGaugeFreedom<3>();
}

TEST(OptimizePoseGraph, ResultDoesNotDependOnTheOrderOfPoses) {
  PoseGraph3 graph = NoisyGraph<3>(30, 0.1, 0.05, 8), mixed = graph;
  std::vector<int> order(graph.poses.size());
  std::iota(order.begin(), order.end(), 0);
  std::shuffle(order.begin(), order.end(), std::mt19937_64(9));
  for (std::size_t i = 0; i < order.size(); ++i) mixed.poses[order[i]] = graph.poses[i];
  for (GraphEdge<3>& edge : mixed.edges) {
    edge.from = order[edge.from];
    edge.to = order[edge.to];
  }
  OptimizePoseGraph(&graph);
  OptimizePoseGraph(&mixed);
  std::vector<GraphPose<3>> back;
  for (const int i : order) back.push_back(mixed.poses[i]);
  EXPECT_LT(LargestDifference(graph.poses, back), 1e-8);
}

TEST(OptimizePoseGraph, FixedPosesStayAndPartsAreHeldEach) {
  PoseGraph3 graph = NoisyGraph<3>(20, 0.1, 0.05, 10);
  PoseGraph3 both = graph;
  for (const GraphPose<3>& pose : graph.poses) both.poses.push_back(pose);
  for (GraphEdge<3> edge : graph.edges) {
    edge.from += 20;
    edge.to += 20;
    both.edges.push_back(edge);
  }
  both.fixed.assign(40, false);
  both.fixed[23] = true;
  const auto before = both.poses;
  OptimizePoseGraph(&both);
  EXPECT_EQ(both.poses[0].translation, before[0].translation);
  EXPECT_EQ(both.poses[23].translation, before[23].translation);
  EXPECT_NE(both.poses[20].translation, before[20].translation);
  EXPECT_EQ(ConnectedParts(both)[39], 20);
}

TEST(OptimizePoseGraph, ConsistentEdgesAreAtRestAtOnce) {
  PoseGraph3 graph = NoisyGraph<3>(20, 0.0, 0.0, 11);
  const PoseGraphSummary summary = OptimizePoseGraph(&graph);
  EXPECT_TRUE(summary.converged);
  EXPECT_LT(summary.final_cost, 1e-15);
}

TEST(OptimizePoseGraph, RefusesBadIndices) {
  PoseGraph3 graph = NoisyGraph<3>(5, 0.0, 0.0, 12);
  graph.edges[0].to = 5;
  EXPECT_THROW(OptimizePoseGraph(&graph), std::invalid_argument);
  graph.edges[0].to = graph.edges[0].from;
  EXPECT_THROW(OptimizePoseGraph(&graph), std::invalid_argument);
}

// False closures: as many as there are true ones, each between random poses with a random
// measurement. The truth is known, so are the false ones.
template <int Dim>
void ExpectFalseClosuresRejected(std::uint64_t seed) {
  PoseGraph<Dim> graph = NoisyGraph<Dim>(120, 0.02, 0.01, seed);
  const auto truth = graph.poses;
  const std::size_t true_edges = graph.edges.size();
  std::mt19937_64 rng(seed + 100);
  for (int k = 0; k < 38; ++k) {
    const int a = static_cast<int>(rng() % 60), b = 60 + static_cast<int>(rng() % 60);
    graph.edges.push_back({a, b, RandomPose<Dim>(&rng), graph.edges[0].information, true});
  }
  InitializeChordalFromTrusted(&graph);
  // Of a path's edges alone the start is dead reckoning.
  const GraphPose<Dim> second = Compose(graph.poses[0], graph.edges[0].measurement);
  EXPECT_LT((graph.poses[1].translation - second.translation).norm(), 1e-9);
  const GncSummary summary = OptimizeByGnc(&graph);
  int wrong = 0, lost = 0;
  for (std::size_t k = 0; k < graph.edges.size(); ++k) {
    if (k >= true_edges) wrong += summary.weights[k] > 0.5;
    if (k < true_edges) lost += summary.weights[k] < 0.5;
  }
  EXPECT_EQ(wrong, 0) << seed;
  EXPECT_LE(lost, 3) << seed;  // one in a hundred lies beyond the 99 % quantile
  // Dead reckoning over 120 steps of noise: the closures have to keep it far below its drift.
  EXPECT_LT(LargestDifference(graph.poses, truth), 1.5) << seed;
}

TEST(OptimizeByGnc, RejectsFalseClosuresAndThemAlone) {
  for (std::uint64_t seed = 0; seed < 3; ++seed) {
    ExpectFalseClosuresRejected<2>(seed);
    ExpectFalseClosuresRejected<3>(seed);
  }
}

}  // namespace
}  // namespace planegraph
