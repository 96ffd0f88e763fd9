#include "planegraph/solve/covariance.h"

#include <ceres/ceres.h>
#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>

#include "planegraph/geometry/rotation.h"
#include "planegraph/graph/manifolds.h"
#include "planegraph/graph/pose_error.h"
#include "planegraph/solve/solver.h"
#include "solve/assembly.h"
#include "solve/plane_world.h"

namespace planegraph {
namespace {

// Covariances by ceres::Covariance, whose tangent is that of our manifolds.
Eigen::MatrixXd CeresCovariance(const Graph& graph, const SolveOptions& options,
                                const BlockRef& row, const BlockRef& column) {
  Assembly assembly(graph, options);
  Se3Manifold pose_manifold;
  PlaneManifold plane_manifold;
  ceres::Problem::Options problem_options;
  problem_options.cost_function_ownership = ceres::DO_NOT_TAKE_OWNERSHIP;
  problem_options.loss_function_ownership = ceres::DO_NOT_TAKE_OWNERSHIP;
  problem_options.manifold_ownership = ceres::DO_NOT_TAKE_OWNERSHIP;
  ceres::Problem problem(problem_options);
  for (std::size_t i = 0; i < graph.poses.size(); ++i) {
    problem.AddParameterBlock(assembly.PoseBlock(i), kPoseSize, &pose_manifold);
    if (graph.poses[i].fixed) problem.SetParameterBlockConstant(assembly.PoseBlock(i));
  }
  for (const Residual& residual : assembly.residuals()) {
    std::vector<double*> blocks;
    for (std::size_t k = 0; k < residual.blocks.size(); ++k) {
      blocks.push_back(assembly.Block(residual.blocks[k]));
      if (residual.blocks[k].kind == BlockKind::kPlane) {
        problem.AddParameterBlock(blocks[k], kPlaneSize, &plane_manifold);
      }
    }
    problem.AddResidualBlock(residual.cost.get(), residual.loss, blocks);
  }
  ceres::Covariance covariance{ceres::Covariance::Options()};
  const double *a = assembly.Block(row), *b = assembly.Block(column);
  const std::vector<std::pair<const double*, const double*>> wanted = {{a, b}};
  EXPECT_TRUE(covariance.Compute(wanted, &problem));
  const auto tangent = [](const BlockRef& block) {
    return block.kind == BlockKind::kPose ? kPoseTangent : kPlaneTangent;
  };
  Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor> result(tangent(row),
                                                                                tangent(column));
  covariance.GetCovarianceBlockInTangentSpace(a, b, result.data());
  return result;
}

BlockRef PoseBlockRef(int pose) { return {BlockKind::kPose, pose}; }

class AgainstCeres : public testing::TestWithParam<const char*> {};

TEST_P(AgainstCeres, PoseCovariances) {
  PlaneWorld world({.poses = 5, .planes = 30, .noise = 1.0});
  Graph graph = world.Disturbed(0.01, 0.01);
  AddOdometry(0.05, 0.01, &graph);
  SolveOptions options;
  options.plane_factor = GetParam();
  Solve(&graph, options);
  const GraphCovariance covariance(graph, options);
  for (int i = 1; i < 5; ++i) {
    const Matrix6d expected = CeresCovariance(graph, options, PoseBlockRef(i), PoseBlockRef(i));
    EXPECT_LT((covariance.Pose(i) - expected).norm(), 1e-6 * expected.norm());
  }
  EXPECT_EQ(covariance.Pose(0).norm(), 0.0);  // fixed
}

INSTANTIATE_TEST_SUITE_P(PlaneFactors, AgainstCeres,
                         testing::Values("moments", "pose_pose", "normal_offset", "closest_point",
                                         "unit_quaternion"));

// Planes, also where factors tie them, of the factors that have planes as unknowns.
TEST(GraphCovariance, PlanesAgainstCeres) {
  PlaneWorld world({.poses = 4, .planes = 20, .noise = 1.0});
  Graph graph = world.Disturbed(0.01, 0.01);
  graph.plane_factors = {{.type = "parallel", .planes = {2, 5}},
                         {.type = "perpendicular", .planes = {5, 7}, .sigma_angle = 0.1}};
  SolveOptions options;
  options.plane_factor = "normal_offset";
  Solve(&graph, options);
  const GraphCovariance covariance(graph, options);
  for (int k = 0; k < 10; ++k) {
    if (graph.planes[k].observations.size() < 2) continue;
    const BlockRef block{BlockKind::kPlane, k};
    const Eigen::Matrix3d expected = CeresCovariance(graph, options, block, block);
    EXPECT_LT((covariance.Plane(k) - expected).norm(), 1e-6 * expected.norm()) << k;
  }
}

// The joint covariance of relative poses holds each of them, and their correlations by Ceres.
TEST(GraphCovariance, RelativePosesJointlyAgainstCeres) {
  PlaneWorld world({.poses = 5, .planes = 30, .noise = 1.0});
  Graph graph = world.Disturbed(0.01, 0.01);
  Solve(&graph);
  const GraphCovariance covariance(graph);
  const Eigen::MatrixXd joint = covariance.Relatives(0, {1, 3});
  ASSERT_EQ(joint.rows(), 12);
  EXPECT_LT((joint.topLeftCorner<6, 6>() - covariance.Relative(0, 1)).norm(), 1e-9 * joint.norm());
  EXPECT_LT((joint.bottomRightCorner<6, 6>() - covariance.Relative(0, 3)).norm(),
            1e-9 * joint.norm());
  // Pose 0 is held: relative to it is in its axes.
  Matrix6d turn = Matrix6d::Zero();
  turn.topLeftCorner<3, 3>() = graph.poses[0].world_from_node.rotation.toRotationMatrix();
  turn.bottomRightCorner<3, 3>() = turn.topLeftCorner<3, 3>();
  const Eigen::MatrixXd cross = CeresCovariance(graph, {}, PoseBlockRef(1), PoseBlockRef(3));
  EXPECT_LT((turn * joint.topRightCorner<6, 6>() * turn.transpose() - cross).norm(),
            1e-6 * cross.norm());
}

TEST(GraphCovariance, APlaneThatIsHalfSeenHasNone) {
  PlaneWorld world({.poses = 3, .planes = 30});
  Graph graph = world.truth();
  for (PlaneObservation& seen : graph.planes[0].observations) seen.tilt_weight_2 = 0.0;
  graph.planes[0].observations.resize(1);
  EXPECT_FALSE(GraphCovariance(graph).Plane(0).allFinite());
  EXPECT_TRUE(GraphCovariance(graph).Plane(1).allFinite());
}

TEST(GraphCovariance, PoseErrorsHaveTheStatedSize) {
  // Normalized estimation error squared over many worlds: chi-square with 6 degrees of freedom
  // each.
  double nees = 0.0, relative_nees = 0.0;
  int count = 0;
  for (std::uint64_t seed = 1; seed <= 60; ++seed) {
    PlaneWorld world({.poses = 4, .planes = 25, .noise = 1.0, .seed = seed});
    Graph graph = world.Disturbed(0.01, 0.01);
    Solve(&graph);
    const GraphCovariance covariance(graph);
    for (int i = 1; i < 4; ++i, ++count) {
      const Vector6d error =
          PoseError(graph.poses[i].world_from_node, world.truth().poses[i].world_from_node);
      nees += error.dot(covariance.Pose(i).llt().solve(error));
      const int j = i == 3 ? 1 : i + 1;
      const auto relative = [&](const Graph& g) {
        return g.poses[i].world_from_node.Inverse() * g.poses[j].world_from_node;
      };
      const Vector6d relative_error = PoseError(relative(graph), relative(world.truth()));
      relative_nees += relative_error.dot(covariance.Relative(i, j).llt().solve(relative_error));
    }
  }
  // The poses of one world are correlated; 60 worlds x 6 are independent: sigma of the mean <
  // 0.075.
  EXPECT_NEAR(nees / (6.0 * count), 1.0, 0.2);
  EXPECT_NEAR(relative_nees / (6.0 * count), 1.0, 0.2);
}

struct Scene {
  int directions;  // of plane normals
  int open_translations, open_rotations;
};

class PlaneDirections : public testing::TestWithParam<Scene> {};

TEST_P(PlaneDirections, LeaveExactlyTheirNullDirectionsOpen) {
  const Scene scene = GetParam();
  PlaneWorld world({.poses = 4, .planes = 30, .seen_share = 0.9, .directions = scene.directions});
  Graph graph = world.truth();
  const GraphCovariance by_planes(graph);
  AddOdometry(0.5, 0.02, &graph);
  const GraphCovariance with_odometry(graph);
  for (int i = 1; i < 4; ++i) {
    const auto open = by_planes.Unobserved(i);
    const auto held = with_odometry.Unobserved(i);
    const auto is_rotation = [](const UnobservedDirection& u) {
      return u.direction.tail<3>().norm() > 0.5;
    };
    const int rotations = static_cast<int>(std::count_if(open.begin(), open.end(), is_rotation));
    EXPECT_EQ(rotations, scene.open_rotations);
    EXPECT_EQ(static_cast<int>(open.size()) - rotations, scene.open_translations);
    ASSERT_EQ(held.size(), open.size());
    for (std::size_t k = 0; k < open.size(); ++k) {
      EXPECT_NEAR(open[k].direction.norm(), 1.0, 1e-12);
      EXPECT_TRUE(std::isinf(open[k].sigma));
      EXPECT_EQ(open[k].held_by, "");
      EXPECT_TRUE(std::isfinite(held[k].sigma));
      EXPECT_EQ(held[k].held_by, "odometry");
    }
  }
}

// One direction (normals along x): the translations along y and z and the rotation about x are
// free. Two (x and y): the translation along z. Three: nothing.
INSTANTIATE_TEST_SUITE_P(Scenes, PlaneDirections,
                         testing::Values(Scene{1, 2, 1}, Scene{2, 1, 0}, Scene{3, 0, 0}));

TEST(GraphCovariance, NamesTheDirectionAlongACorridorAndTheSigmaOfOdometry) {
  PlaneWorld world({.poses = 4, .planes = 40, .seen_share = 0.9, .directions = 2});
  Graph graph = world.truth();
  AddOdometry(0.5, 0.02, &graph);
  const GraphCovariance covariance(graph);
  for (int i = 1; i < 4; ++i) {
    const auto open = covariance.Unobserved(i);
    ASSERT_EQ(open.size(), 1u);
    EXPECT_NEAR(open[0].direction[2], 1.0, 1e-9);
    EXPECT_NEAR(open[0].sigma, 0.5 * std::sqrt(double(i)), 0.01);  // a chain of i steps
    EXPECT_NEAR(std::sqrt(covariance.Pose(i)(2, 2)), open[0].sigma, 1e-6);
    EXPECT_LT(std::sqrt(covariance.Pose(i)(0, 0)), 0.02);
    EXPECT_LT(std::sqrt(covariance.Pose(i)(1, 1)), 0.02);
  }
  const auto pair = covariance.UnobservedRelative(1, 2);
  ASSERT_EQ(pair.size(), 1u);
  EXPECT_NEAR(pair[0].sigma, 0.5, 0.01);
  // In the axes of the target.
  const Eigen::Vector3d along =
      graph.poses[1].world_from_node.rotation.conjugate() * Eigen::Vector3d::UnitZ();
  EXPECT_NEAR(std::abs(pair[0].direction.head<3>().dot(along)), 1.0, 1e-9);
}

TEST(GraphCovariance, InfiniteVariancesAreNaNAndTheOthersStayRight) {
  PlaneWorld world({.poses = 3, .planes = 40, .seen_share = 0.9, .directions = 2});
  Graph graph = world.truth();
  const Matrix6d open = GraphCovariance(graph).Pose(1);
  AddOdometry(1e3, 1e3, &graph);
  const Matrix6d held = GraphCovariance(graph).Pose(1);
  for (int a = 0; a < 6; ++a) {
    for (int b = 0; b < 6; ++b) {
      if (a == 2 || b == 2) {
        EXPECT_TRUE(std::isnan(open(a, b)));
      } else {
        EXPECT_NEAR(open(a, b), held(a, b), 1e-5 * std::sqrt(held(a, a) * held(b, b)));
      }
    }
  }
}

TEST(GraphCovariance, APoseThatNothingTiesIsUnobserved) {
  PlaneWorld world({.poses = 3, .planes = 30});
  Graph graph = world.truth();
  graph.poses.push_back({"alone", Rigid3()});
  const GraphCovariance covariance(graph);
  EXPECT_EQ(covariance.Unobserved(3).size(), 6u);
  EXPECT_TRUE(std::isnan(covariance.Pose(3)(0, 0)));
  EXPECT_EQ(covariance.Unobserved(1).size(), 0u);
}

TEST(GraphCovariance, DroppingAPlaneNeverLowersTheUncertainty) {
  PlaneWorld world({.poses = 4, .planes = 15});
  Graph graph = world.truth();
  const Matrix6d full = GraphCovariance(graph).Pose(3);
  for (int drop = 0; drop < 5; ++drop) {
    Graph less = graph;
    less.planes.erase(less.planes.begin() + drop);
    const Matrix6d more = GraphCovariance(less).Pose(3);
    const Eigen::SelfAdjointEigenSolver<Matrix6d> solver(more - full);
    EXPECT_GT(solver.eigenvalues().minCoeff(), -1e-9 * full.norm());
    EXPECT_GT(more.trace(), full.trace() * (1.0 - 1e-9));
  }
}

TEST(GraphCovariance, RelativeCovarianceDoesNotDependOnTheGauge) {
  PlaneWorld world({.poses = 4, .planes = 30});
  Graph graph = world.truth();
  const Matrix6d by_first = GraphCovariance(graph).Relative(1, 2);
  graph.poses[0].fixed = false;
  graph.poses[3].fixed = true;
  const Matrix6d by_last = GraphCovariance(graph).Relative(1, 2);
  EXPECT_LT((by_first - by_last).norm(), 1e-8 * by_first.norm());
  graph.poses[3].fixed = false;
  graph.poses[1].fixed = true;
  // With the target held, the relative covariance is that of the source, in the target's axes.
  const Eigen::Matrix3d turn =
      graph.poses[1].world_from_node.rotation.toRotationMatrix().transpose();
  const Matrix6d source = GraphCovariance(graph).Pose(2);
  EXPECT_LT(
      (turn * source.topLeftCorner<3, 3>() * turn.transpose() - by_first.topLeftCorner<3, 3>())
          .norm(),
      1e-8 * by_first.norm());
}

TEST(GraphCovariance, APriorAloneIsItsCovariance) {
  Graph graph;
  graph.poses = {{"a", Rigid3(ExpSO3({0.1, 0.5, 1.0}), {1, 2, 3})}};
  const Matrix6d information = OdometryInformation(0.2, 0.01);
  graph.pose_factors = {MakePosePrior(0, graph.poses[0].world_from_node, information)};
  EXPECT_LT((GraphCovariance(graph).Pose(0) - information.inverse()).norm(), 1e-12);
}

}  // namespace
}  // namespace planegraph
