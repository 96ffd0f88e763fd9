// The plane factors against each other, and what ties planes.
#include <gtest/gtest.h>

#include <Eigen/LU>
#include <cmath>

#include "planegraph/base/error.h"
#include "planegraph/solve/covariance.h"
#include "planegraph/solve/marginal_graph.h"
#include "planegraph/solve/solver.h"
#include "solve/assembly.h"
#include "solve/information.h"
#include "solve/plane_world.h"

namespace planegraph {
namespace {

using Eigen::Vector3d;

SolveOptions With(const std::string& factor) {
  SolveOptions options;
  options.plane_factor = factor;
  return options;
}

Graph Solved(const Graph& start, const std::string& factor) {
  Graph graph = start;
  SolveOptions options;
  options.plane_factor = factor;
  EXPECT_TRUE(Solve(&graph, options).converged) << factor;
  return graph;
}

TEST(Eliminated, HasTheMinimumOfTheLandmarks) {
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    PlaneWorld world({.poses = 8, .planes = 50, .noise = 1.0, .seed = seed});
    const Graph start = world.Disturbed(0.1, 0.05);
    const Graph landmarks = Solved(start, "moments"), eliminated = Solved(start, "eliminated");
    EXPECT_LT(LargestPoseDifference(landmarks, eliminated), 1e-6);  // the solver's tolerance
  }
}

TEST(Eliminated, CostIsThatOfTheLandmarksAtTheirBestPlanes) {
  PlaneWorld world({.poses = 6, .planes = 30, .noise = 1.0});
  Graph graph = world.Disturbed(0.05, 0.02);
  for (PlaneLandmark& plane : graph.planes) FitLandmark(graph, &plane);
  std::vector<double> landmarks(graph.planes.size()), eliminated(graph.planes.size());
  for (const auto& r : EvaluateResiduals(graph)) landmarks[r.tag.plane] += r.chi2;
  for (const auto& r : EvaluateResiduals(graph, With("eliminated"))) {
    eliminated[r.tag.plane] = r.weight * r.chi2;
  }
  for (std::size_t k = 0; k < graph.planes.size(); ++k) {
    if (graph.planes[k].observations.size() < 2) continue;
    EXPECT_NEAR(eliminated[k] / landmarks[k], 1.0, 1e-9);
  }
}

// Gauss-Newton that sees the whole curvature needs no more steps than the landmarks do.
TEST(Eliminated, ConvergesLikeTheLandmarks) {
  PlaneWorld world({.poses = 10, .planes = 80, .noise = 1.0});
  Graph a = world.Disturbed(0.3, 0.1), b = a;
  const SolveSummary landmarks = Solve(&a), eliminated = Solve(&b, With("eliminated"));
  EXPECT_LE(eliminated.iterations, landmarks.iterations + 3);
}

TEST(Eliminated, GivesTheCovariancesAndEdgesOfTheLandmarks) {
  PlaneWorld world({.poses = 5, .planes = 30});
  const GraphCovariance landmarks(world.truth());
  const GraphCovariance eliminated(world.truth(), With("eliminated"));
  EXPECT_LT((landmarks.Pose(3) - eliminated.Pose(3)).norm(), 1e-9 * landmarks.Pose(3).norm());
  const auto a = MarginalEdges(world.truth(), {{1, 2}});
  const auto b = MarginalEdges(world.truth(), {{1, 2}}, With("eliminated"));
  EXPECT_LT((a[0].information - b[0].information).norm(), 1e-9 * a[0].information.norm());
}

// Over worlds and poses: root of the mean squared distance of a factor's minimum from that of
// `moments`, in sigmas.
double DifferenceFromMoments(const std::string& factor) {
  double sum = 0.0;
  int count = 0;
  for (std::uint64_t seed = 1; seed <= 10; ++seed) {
    PlaneWorld world({.poses = 6, .planes = 60, .noise = 1.0, .seed = seed});
    const Graph moments = Solved(world.truth(), "moments"), other = Solved(world.truth(), factor);
    const GraphCovariance covariance(moments);
    for (int i = 1; i < 6; ++i, ++count) {
      const Vector3d difference =
          moments.poses[i].world_from_node.translation - other.poses[i].world_from_node.translation;
      sum += difference.squaredNorm() / covariance.Pose(i).topLeftCorner<3, 3>().trace();
    }
  }
  return std::sqrt(sum / count);
}

// Forms of one and the same measurement: what is left is of second order in its noise, at most
// distance * tilt^2 / 2 of an offset: 20 m (5 mrad)^2 / 2 is 2.5 % of 1 cm.
TEST(PlaneFactors, FormsOfTheLandmarkAgree) {
  for (const char* factor : {"normal_offset", "closest_point", "unit_quaternion"}) {
    EXPECT_LT(DifferenceFromMoments(factor), 0.05) << factor;
  }
}

// Pairs of measurements, weighted as if they were independent and equal: another estimate of the
// same poses, and not the best one. Such a difference has the variance that it is worse by
// (Hausman 1978): 0.3 sigma are 9 %.
TEST(PlaneFactors, PairsOfPosesAreNearlyAsGood) {
  EXPECT_LT(DifferenceFromMoments("pose_pose"), 0.3);
}

TEST(UnitQuaternion, TheUnitOfLengthIsAnOption) {
  PlaneWorld world({.poses = 6, .planes = 60});
  Graph graph = world.Disturbed(0.2, 0.05);
  SolveOptions options;
  options.plane_factor = "unit_quaternion";
  options.plane_factor_options = {{"unit_length", 10.0}};
  EXPECT_TRUE(Solve(&graph, options).converged);
  EXPECT_LT(LargestPoseDifference(graph, world.truth()), 1e-8);
}

// A world whose observations hold points, and moments of exactly these with one sigma for each.
Graph WorldOfPoints(int poses, int planes, int points, std::mt19937_64* rng) {
  std::normal_distribution<double> normal;
  Graph graph;
  for (int i = 0; i < poses; ++i) {
    const Vector3d turn(normal(*rng), normal(*rng), normal(*rng));
    graph.poses.push_back({std::to_string(i), Rigid3(ExpSO3(turn), {3.0 * i, 0, 0}), i == 0});
  }
  constexpr double kSigma = 0.01;
  for (int k = 0; k < planes; ++k) {
    PlaneLandmark plane;
    plane.normal = Vector3d(normal(*rng), normal(*rng), normal(*rng)).normalized();
    plane.anchor = 5.0 * Vector3d(normal(*rng), normal(*rng), normal(*rng));
    const auto basis = TangentBasis(plane.normal);
    for (int i = 0; i < poses; ++i) {
      auto cloud = std::make_shared<std::vector<Vector3d>>();
      Moments moments;
      for (int p = 0; p < points; ++p) {
        const Eigen::Vector2d at(normal(*rng), normal(*rng));
        const Vector3d point = plane.anchor + basis * at + kSigma * normal(*rng) * plane.normal;
        cloud->push_back(graph.poses[i].world_from_node.Inverse() * point);
        moments.Add(cloud->back());
      }
      const PrincipalAxes axes = ComputePrincipalAxes(moments.scatter);
      PlaneObservation seen;
      seen.pose = i;
      seen.centroid = moments.mean;
      seen.axes = axes.vectors;
      seen.eigenvalues = axes.values;
      seen.tilt_weight_1 = std::sqrt(axes.values[1]) / kSigma;
      seen.tilt_weight_2 = std::sqrt(axes.values[2]) / kSigma;
      seen.offset_weight = std::sqrt(moments.count) / kSigma;
      seen.points = cloud;
      plane.observations.push_back(seen);
    }
    graph.planes.push_back(plane);
  }
  return graph;
}

TEST(RawPoints, SumIsThatOfTheMoments) {
  std::mt19937_64 rng(3);
  for (int trial = 0; trial < 10; ++trial) {
    const Graph graph = WorldOfPoints(3, 4, 500, &rng);
    const auto raw = EvaluateResiduals(graph, With("raw_points"));
    const auto moments = EvaluateResiduals(graph);
    ASSERT_EQ(raw.size(), moments.size());
    for (std::size_t k = 0; k < raw.size(); ++k) {
      // What the moments leave out: the thickness along the normal, which no pose changes much.
      const PlaneLandmark& plane = graph.planes[raw[k].tag.plane];
      const PlaneObservation& seen = plane.observations[raw[k].tag.observation];
      const Vector3d n = graph.poses[seen.pose].world_from_node.rotation.conjugate() * plane.normal;
      const double thickness = seen.eigenvalues[0] * std::pow(seen.axes.col(0).dot(n), 2) / 1e-4;
      EXPECT_NEAR((moments[k].chi2 + thickness) / raw[k].chi2, 1.0, 1e-9);
    }
  }
}

TEST(RawPoints, MinimumIsThatOfTheMoments) {
  std::mt19937_64 rng(4);
  Graph graph = WorldOfPoints(4, 10, 300, &rng);
  graph.poses[2].world_from_node.translation += Vector3d(0.1, -0.1, 0.05);
  const Graph raw = Solved(graph, "raw_points"), moments = Solved(graph, "moments");
  // The thickness turns with the plane: 1 % of a patch's extent squared of a tilt's millirad.
  EXPECT_LT(LargestPoseDifference(raw, moments), 1e-5);
}

TEST(RawPoints, NeedsPoints) {
  PlaneWorld world({.poses = 3, .planes = 5});
  Graph graph = world.truth();
  EXPECT_THROW(Solve(&graph, With("raw_points")), UsageError);
}

// Two walls that one pose each sees, and nothing in common: the constraint alone joins them.
TEST(PlanePairs, HoldWhatTheySay) {
  for (const char* relation : {"parallel", "perpendicular", "coplanar"}) {
    PlaneWorld world({.poses = 4, .planes = 30});
    Graph graph = world.truth();
    PlaneFactor factor;
    factor.type = relation;
    factor.planes = {0, 1};
    factor.sigma_angle = factor.sigma_offset = 1e-7;
    graph.plane_factors = {factor};
    const SolveSummary summary = Solve(&graph);
    EXPECT_TRUE(summary.usable);
    EXPECT_EQ(summary.linear_solver, "SPARSE_NORMAL_CHOLESKY");
    const Plane a = graph.planes[0].WorldPlane(), b = graph.planes[1].WorldPlane();
    const double cosine = a.normal.dot(b.normal);
    if (factor.type == "perpendicular") {
      EXPECT_NEAR(cosine, 0.0, 1e-5);
    } else {
      EXPECT_NEAR(std::abs(cosine), 1.0, 1e-5);
    }
    if (factor.type == "coplanar") {
      EXPECT_NEAR(a.SignedDistance(graph.planes[1].anchor + graph.planes[1].offset * b.normal), 0.0,
                  1e-5);
    }
  }
}

TEST(PlanePairs, CovarianceIsThatOfTheDenseInverse) {
  PlaneWorld world({.poses = 4, .planes = 12, .seen_share = 0.7, .directions = 3});
  Graph graph = world.truth();
  for (const auto& [type, a, b] :
       {std::tuple("parallel", 0, 6), {"coplanar", 3, 9}, {"perpendicular", 3, 4}}) {
    PlaneFactor factor;
    factor.type = type;
    factor.planes = {a, b};
    graph.plane_factors.push_back(factor);
  }
  // All poses and planes in one matrix, the first pose held.
  const int poses = 6 * 4, rows = poses + 3 * static_cast<int>(graph.planes.size());
  Eigen::MatrixXd information = Eigen::MatrixXd::Zero(rows, rows);
  Assembly assembly(graph, {});
  LinearizedResidual linear;
  for (const Residual& residual : assembly.residuals()) {
    assembly.Linearize(residual, &linear);
    const auto row = [&](const BlockRef& b) {
      return b.kind == BlockKind::kPlane ? poses + 3 * b.index : 6 * b.index;
    };
    for (std::size_t a = 0; a < residual.blocks.size(); ++a) {
      for (std::size_t b = 0; b < residual.blocks.size(); ++b) {
        const Eigen::MatrixXd product = linear.jacobians[a].transpose() * linear.jacobians[b];
        information.block(row(residual.blocks[a]), row(residual.blocks[b]), product.rows(),
                          product.cols()) += product;
      }
    }
  }
  const Eigen::MatrixXd dense =
      information.bottomRightCorner(rows - 6, rows - 6).fullPivLu().inverse();
  const GraphCovariance covariance(graph);
  for (int i = 1; i < 4; ++i) {
    const Matrix6d expected = dense.block<6, 6>(6 * (i - 1), 6 * (i - 1));
    EXPECT_LT((covariance.Pose(i) - expected).norm(), 1e-6 * expected.norm());
  }
}

TEST(PlanePairs, NeedPlanesAsUnknowns) {
  PlaneWorld world({.poses = 3, .planes = 10});
  Graph graph = world.truth();
  graph.plane_factors.resize(1);
  graph.plane_factors[0].planes = {0, 1};
  EXPECT_THROW(Solve(&graph, With("pose_pose")), UsageError);
  graph.plane_factors[0].planes = {0, 0};
  EXPECT_THROW(Solve(&graph), std::invalid_argument);
  graph.plane_factors[0].planes = {0, 99};
  EXPECT_THROW(Solve(&graph), std::invalid_argument);
}

}  // namespace
}  // namespace planegraph
