#include "solve/residual_scatter.h"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numeric>

#include "planegraph/graph/pose_error.h"
#include "planegraph/solve/covariance.h"
#include "planegraph/solve/solver.h"
#include "solve/plane_world.h"

namespace planegraph {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

CovarianceOptions ByResiduals() { return {.noise = CovarianceNoise::kResiduals}; }

SolveOptions Robust() {
  SolveOptions options;
  options.plane_loss = {"cauchy", 2.4};
  options.function_tolerance = 1e-14;
  options.max_iterations = 100;
  return options;
}

Graph Solved(const PlaneWorldOptions& world, const SolveOptions& options = Robust()) {
  Graph graph = PlaneWorld(world).Disturbed(0.003, 0.003);
  Solve(&graph, options);
  return graph;
}

// The same by the whole Jacobian, no plane eliminated, nothing sparse.
class Dense {
 public:
  Dense(const Graph& graph, const SolveOptions& options) : graph_(graph) {
    for (const auto& plane : LinearizeGraph(graph, options).planes) {
      for (const PlaneResidual& residual : plane) Add(residual);
    }
    const VectorXd curvature = Curvatures();
    const MatrixXd sharp = curvature.cwiseSqrt().asDiagonal() * jacobian_;
    const MatrixXd inverse = (sharp.transpose() * sharp).inverse();
    const VectorXd variances = Variances(sharp, inverse);
    covariance = inverse * jacobian_.transpose() * variances.asDiagonal() * jacobian_ * inverse;
  }

  Index PoseRow(int pose) const { return 6 * (pose - 1); }
  Index PlaneRow(int plane) const {
    return 6 * static_cast<Index>(graph_.poses.size() - 1) + 3 * plane;
  }

  MatrixXd covariance;  // of the poses behind the first, which is fixed, then of the planes

 private:
  void Add(const PlaneResidual& residual) {
    const Index at = jacobian_.rows();
    jacobian_.conservativeResize(at + 3, PlaneRow(static_cast<int>(graph_.planes.size())));
    jacobian_.bottomRows(3).setZero();
    residual_.conservativeResize(at + 3);
    residual_.tail(3) = residual.linear.residual;
    planes_.push_back(residual.tag.plane);
    radial_.push_back(residual.linear.radial_curvature);
    for (std::size_t k = 0; k < residual.blocks.size(); ++k) {
      const BlockRef& block = residual.blocks[k];
      const bool is_plane = block.kind == BlockKind::kPlane;
      if (!is_plane && block.index == 0) continue;
      const MatrixXd& by_block = residual.linear.jacobians[k];
      jacobian_.block(at, is_plane ? PlaneRow(block.index) : PoseRow(block.index), 3,
                      by_block.cols()) = by_block;
    }
  }

  VectorXd Curvatures() const {
    Eigen::Vector3d share = Eigen::Vector3d::Zero();
    for (Index k = 0; k < residual_.size(); ++k) share[k % 3] += residual_[k] * residual_[k];
    share /= residual_.squaredNorm();
    VectorXd curvature(residual_.size());
    for (Index k = 0; k < residual_.size(); ++k) curvature[k] = 1.0 + radial_[k / 3] * share[k % 3];
    return curvature;
  }

  // Of rows: squares, redundancy, its sum with the leverage once more, leverage on the poses; all
  // but the last times the leverage.
  using Sums = Eigen::Vector4d;
  static double Freedom(const Sums& sums) { return sums[1] * sums[1] / sums[2]; }

  VectorXd Variances(const MatrixXd& sharp, const MatrixXd& inverse) const {
    const MatrixXd hat = sharp * inverse * sharp.transpose();
    std::array<Sums, 3> all = {Sums::Zero(), Sums::Zero(), Sums::Zero()};
    std::map<std::pair<int, Index>, Sums> own;
    for (Index k = 0; k < residual_.size(); ++k) {
      const auto plane = sharp.middleCols<3>(PlaneRow(planes_[k / 3]));
      const MatrixXd in_plane = (plane.transpose() * plane).inverse();
      const double on_plane = plane.row(k) * in_plane * plane.row(k).transpose();
      const double h = hat(k, k) - on_plane, redundancy = 1.0 - hat(k, k);
      const Sums one(h * residual_[k] * residual_[k], h * redundancy, h * h * redundancy, h);
      own.try_emplace({planes_[k / 3], k % 3}, Sums::Zero()).first->second += one;
      all[k % 3] += one;
    }
    double sum = 0.0, sum_of_squares = 0.0;
    for (const auto& [key, value] : own) {
      sum += value[3];
      sum_of_squares += value[3] * value[3] / std::max(1.0, Freedom(value));
    }
    const double whole = sum * sum / sum_of_squares;
    VectorXd variances(residual_.size());
    for (Index k = 0; k < residual_.size(); ++k) {
      const Sums &value = own.at({planes_[k / 3], k % 3}), &of_all = all[k % 3];
      const double common =
          (Freedom(of_all) * of_all[0] / of_all[1] + 2.0) / (Freedom(of_all) + 2.0);
      const double freedom = Freedom(value), borrowed = std::max(0.0, 1.0 - freedom);
      const double factor =
          (freedom * value[0] / value[1] + borrowed * common) / (freedom + borrowed);
      variances[k] = (whole * factor + 2.0) / (whole + 2.0);
    }
    return variances;
  }

  const Graph& graph_;
  MatrixXd jacobian_;
  VectorXd residual_;
  std::vector<int> planes_;
  std::vector<double> radial_;
};

TEST(ResidualScatter, IsThatOfADenseComputation) {
  const Graph graph = Solved({.poses = 5, .planes = 25, .seen_share = 0.8, .noise = 1.0});
  ASSERT_TRUE(std::all_of(graph.planes.begin(), graph.planes.end(),
                          [](const auto& plane) { return plane.observations.size() > 1; }));
  const Dense dense(graph, Robust());
  const GraphCovariance covariance(graph, Robust(), ByResiduals());
  for (int i = 1; i < 5; ++i) {
    const Matrix6d expected = dense.covariance.block<6, 6>(dense.PoseRow(i), dense.PoseRow(i));
    EXPECT_LT((covariance.Pose(i) - expected).norm(), 1e-6 * expected.norm()) << i;
  }
  for (int k = 0; k < static_cast<int>(graph.planes.size()); ++k) {
    const Eigen::Matrix3d expected =
        dense.covariance.block<3, 3>(dense.PlaneRow(k), dense.PlaneRow(k));
    EXPECT_LT((covariance.Plane(k) - expected).norm(), 1e-6 * expected.norm()) << k;
  }
}

// Poses that the elimination ties and others, relative to each other and jointly.
TEST(ResidualScatter, RelativePosesDoNotDependOnTheElimination) {
  Graph graph = PlaneWorld({.poses = 10, .planes = 150, .seen_share = 0.9, .noise = 1.0}).truth();
  for (PlaneLandmark& plane : graph.planes) {
    const int first = plane.user_tag % 9;
    std::erase_if(plane.observations, [&](const PlaneObservation& seen) {
      return seen.pose < first || seen.pose > first + 1;
    });
  }
  std::erase_if(graph.planes, [](const auto& plane) { return plane.observations.empty(); });
  Solve(&graph, Robust());
  const GraphCovariance covariance(graph, Robust(), ByResiduals());
  const MatrixXd joint = covariance.Relatives(2, {3, 9, 0});
  const int others[] = {3, 9, 0};
  for (Index k = 0; k < 3; ++k) {
    const Matrix6d expected = joint.block<6, 6>(6 * k, 6 * k);
    EXPECT_LT((covariance.Relative(2, others[k]) - expected).norm(), 1e-7 * expected.norm());
  }
}

TEST(ResidualScatter, DoesNotDependOnTheGauge) {
  Graph graph = Solved({.poses = 4, .planes = 25, .noise = 1.0});
  const Matrix6d by_first = GraphCovariance(graph, Robust(), ByResiduals()).Relative(1, 2);
  graph.poses[0].fixed = false;
  graph.poses[3].fixed = true;
  const Matrix6d by_last = GraphCovariance(graph, Robust(), ByResiduals()).Relative(1, 2);
  EXPECT_LT((by_first - by_last).norm(), 1e-6 * by_first.norm());
}

TEST(ResidualScatter, DoesNotDependOnTheOrderOfScans) {
  const Graph graph = Solved({.poses = 5, .planes = 30, .noise = 1.0});
  Graph turned = graph;
  std::reverse(turned.poses.begin(), turned.poses.end());
  std::reverse(turned.planes.begin(), turned.planes.end());
  for (PlaneLandmark& plane : turned.planes) {
    for (PlaneObservation& seen : plane.observations) seen.pose = 4 - seen.pose;
    std::reverse(plane.observations.begin(), plane.observations.end());
  }
  const GraphCovariance one(graph, Robust(), ByResiduals());
  const GraphCovariance other(turned, Robust(), ByResiduals());
  for (int i = 1; i < 5; ++i) {
    EXPECT_LT((one.Pose(i) - other.Pose(4 - i)).norm(), 1e-7 * one.Pose(i).norm()) << i;
  }
}

// Noise of k times what is stated: k^2 times the covariance, without a loss that sees the change.
TEST(ResidualScatter, FollowsTheSizeOfTheNoise) {
  for (const double noise : {0.5, 1.0, 3.0}) {
    std::vector<double> ratios;
    for (std::uint64_t seed = 1; seed <= 40; ++seed) {
      const Graph graph =
          Solved({.poses = 4, .planes = 40, .noise = noise, .seed = seed}, SolveOptions{});
      const Matrix6d stated = GraphCovariance(graph).Pose(2);
      const Matrix6d found = GraphCovariance(graph, {}, ByResiduals()).Pose(2);
      ratios.push_back((stated.inverse() * found).trace() / 6.0 / (noise * noise));
    }
    const double mean = std::accumulate(ratios.begin(), ratios.end(), 0.0) / 40.0;
    double squares = 0.0;
    for (const double ratio : ratios) squares += (ratio - mean) * (ratio - mean);
    const double sigma = std::sqrt(squares / 39.0 / 40.0);
    // 40 planes: degrees of freedom in the tens, and the prior has two halves of four.
    const double by_prior = 2.0 / 40.0 * std::abs(1.0 / (noise * noise) - 1.0);
    EXPECT_NEAR(mean, 1.0, 4.0 * sigma + by_prior) << noise;
    EXPECT_LT(sigma, 0.05);
  }
}

double MeanNees(double noise, const CovarianceOptions& options, int worlds) {
  double squared = 0.0;
  for (int seed = 1; seed <= worlds; ++seed) {
    const PlaneWorldOptions world{
        .poses = 4, .planes = 60, .noise = noise, .seed = static_cast<std::uint64_t>(seed)};
    const Graph graph = Solved(world);
    const Rigid3 truth = PlaneWorld(world).truth().poses[2].world_from_node;
    const Vector6d error = PoseError(graph.poses[2].world_from_node, truth);
    squared += error.dot(GraphCovariance(graph, Robust(), options).Pose(2).llt().solve(error));
  }
  return squared / (6.0 * worlds);
}

// Under a robust loss, whose weights alone promise more than it keeps, and with noise that is not
// what is stated.
TEST(ResidualScatter, PoseErrorsHaveTheSizeThatItSays) {
  constexpr int kWorlds = 100;
  const double sigma = std::sqrt(2.0 / (6.0 * kWorlds));
  for (const double noise : {0.6, 1.0, 1.5}) {
    EXPECT_NEAR(MeanNees(noise, ByResiduals(), kWorlds), 1.0, 4.0 * sigma) << noise;
  }
  EXPECT_LT(MeanNees(0.6, {}, kWorlds), 1.0 - 4.0 * sigma);
  EXPECT_GT(MeanNees(1.5, {}, kWorlds), 1.0 + 4.0 * sigma);
}

// The stated noise of half of the observations, at random, is what it is, of the others three times
// as much: what weighs most has to count most, and that is not half of the rows.
TEST(ResidualScatter, KnowsWhichRowsWeigh) {
  constexpr int kWorlds = 100;
  double squared = 0.0;
  for (int seed = 1; seed <= kWorlds; ++seed) {
    const PlaneWorldOptions world{.poses = 6,
                                  .planes = 60,
                                  .seen_share = 1.0,
                                  .noise = 1.0,
                                  .seed = static_cast<unsigned>(seed)};
    PlaneWorld made(world);
    Graph graph = PlaneWorld(world).Disturbed(0.003, 0.003);
    for (PlaneLandmark& plane : graph.planes) {
      for (PlaneObservation& seen : plane.observations) {
        if (made.Normal() > 0.0) continue;
        seen.tilt_weight_1 /= 3.0, seen.tilt_weight_2 /= 3.0, seen.offset_weight /= 3.0;
      }
    }
    Solve(&graph);
    const Vector6d error =
        PoseError(graph.poses[2].world_from_node, made.truth().poses[2].world_from_node);
    squared += error.dot(GraphCovariance(graph, {}, ByResiduals()).Pose(2).llt().solve(error));
  }
  EXPECT_NEAR(squared / (6.0 * kWorlds), 1.0, 4.0 * std::sqrt(2.0 / (6.0 * kWorlds)));
}

// Along z no plane says anything, with exact normals. Rotations that are known to some mrad move
// the scans along it by millimetres for metres of the way, odometry's sigma is half a metre.
TEST(ResidualScatter, WhatPlanesLeaveOpenStaysWithOdometry) {
  Graph graph = PlaneWorld({.poses = 4, .planes = 40, .directions = 2, .noise = 0.3}).truth();
  const Vector6d information = (Vector6d() << 4, 4, 4, 1e4, 1e4, 1e4).finished();
  for (int i = 0; i < 3; ++i) {
    graph.pose_factors.push_back(MakeRelativePose(
        i, i + 1, graph.poses[i].world_from_node.Inverse() * graph.poses[i + 1].world_from_node,
        information.asDiagonal(), "odometry"));
  }
  const Matrix6d stated = GraphCovariance(graph, Robust()).Pose(3);
  const Matrix6d found = GraphCovariance(graph, Robust(), ByResiduals()).Pose(3);
  EXPECT_NEAR(found(2, 2) / stated(2, 2), 1.0, 1e-4);
  EXPECT_LT(found(0, 0) / stated(0, 0), 0.5);  // across the walls the residuals are small
}

TEST(ResidualScatter, APriorAloneIsItsCovariance) {
  Graph graph;
  graph.poses = {{"a", {}, false}};
  Matrix6d information = Matrix6d::Identity();
  information(0, 0) = 25.0;
  graph.pose_factors = {MakePosePrior(0, Rigid3(), information)};
  const Matrix6d alone = GraphCovariance(graph, {}, ByResiduals()).Pose(0);
  EXPECT_LT((alone - information.inverse()).norm(), 1e-10);
}

// Two scans and three walls leave three degrees of freedom: residuals of zero lower no sigma by
// more than the prior lets them.
TEST(ResidualScatter, FewResidualsDoNotMakeItSure) {
  PlaneWorld world({.poses = 2, .planes = 3, .seen_share = 1.0, .directions = 3});
  const Matrix6d stated = GraphCovariance(world.truth()).Pose(1);
  const Matrix6d found = GraphCovariance(world.truth(), {}, ByResiduals()).Pose(1);
  // Nine components of landmarks at most, each of one degree of freedom.
  for (int k = 0; k < 6; ++k) {
    EXPECT_GT(found(k, k), 2.0 / (9.0 + 2.0) * stated(k, k)) << k;
    EXPECT_LT(found(k, k), 1.001 * stated(k, k)) << k;
  }
}

// Directions that nothing holds are infinite by either noise.
TEST(ResidualScatter, KeepsOpenDirectionsOpen) {
  const Graph graph = PlaneWorld({.poses = 4, .planes = 40, .directions = 2, .noise = 1.0}).truth();
  const Matrix6d stated = GraphCovariance(graph, Robust()).Pose(2);
  const Matrix6d found = GraphCovariance(graph, Robust(), ByResiduals()).Pose(2);
  for (int k = 0; k < 6; ++k) EXPECT_EQ(std::isnan(stated(k, k)), std::isnan(found(k, k))) << k;
  EXPECT_TRUE(std::isnan(found(2, 2)));
}

}  // namespace
}  // namespace planegraph
