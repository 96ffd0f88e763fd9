#include "planegraph/pose_graph/g2o_conversion.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>

#include "planegraph/base/error.h"
#include "planegraph/pose_graph/optimization.h"

namespace planegraph {
namespace {

G2oGraph TwoPoses() {
  G2oGraph file;
  file.vertices3 = {{4, {}}, {9, {Eigen::Quaterniond::Identity(), {1.1, 0.0, 0.0}}}};
  G2oEdge3 edge;
  edge.from = 4;
  edge.to = 9;
  edge.measurement = {Eigen::Quaterniond(Eigen::AngleAxisd(0.2, Eigen::Vector3d::UnitZ())),
                      {1.0, 0.0, 0.0}};
  edge.information.diagonal() << 1.0, 2.0, 4.0, 8.0, 8.0, 16.0;
  edge.information(0, 5) = edge.information(5, 0) = 0.25;
  file.edges3 = {edge};
  return file;
}

// r = (0.1 turned by -0.2 about z, 0, -sin 0.1): by hand.
TEST(MakePoseGraph, ChiSquareIsG2osAndCeres) {
  const double s = -std::sin(0.1), x = 0.1 * std::cos(0.2), y = -0.1 * std::sin(0.2);
  const double translation = x * x + 2.0 * y * y, cross = 2.0 * 0.25 * x * s,
               rotation = 16.0 * s * s;
  const PoseGraph3 half = MakePoseGraph<3>(TwoPoses(), "f.g2o");
  EXPECT_NEAR(EdgeChi2(half, half.edges[0]), translation + cross + rotation, 1e-14);
  G2oConversionOptions options;
  options.rotation_error = RotationError::kFull;
  const PoseGraph3 full = MakePoseGraph<3>(TwoPoses(), "f.g2o", options);
  EXPECT_NEAR(EdgeChi2(full, full.edges[0]), translation + 2.0 * cross + 4.0 * rotation, 1e-14);
  EXPECT_TRUE(full.edges[0].robust);  // ids 4 and 9 do not follow each other
}

TEST(MakePoseGraph, IsotropicWeightsAreHarmonicMeans) {
  G2oConversionOptions options;
  options.information = InformationUse::kIsotropic;
  const PoseGraph3 graph = MakePoseGraph<3>(TwoPoses(), "f.g2o", options);
  const double tau = 3.0 / (1.0 + 0.5 + 0.25), kappa = 1.5 / (0.125 + 0.125 + 0.0625);
  EXPECT_NEAR(graph.edges[0].information(0, 0), tau, 1e-14);
  EXPECT_NEAR(graph.edges[0].information(5, 5), 8.0 * kappa, 1e-13);
  EXPECT_EQ(graph.edges[0].information(0, 5), 0.0);
}

TEST(MakePoseGraph, IndefiniteMatricesAreCountedAndNamed) {
  G2oGraph file = TwoPoses();
  file.edges3.push_back(file.edges3[0]);
  file.edges3[1].information(0, 1) = file.edges3[1].information(1, 0) = 5.0;
  const InformationReport report = CheckInformation(file);
  EXPECT_EQ(report.indefinite, 1u);
  EXPECT_EQ(report.first, "edge 4-9");
  try {
    MakePoseGraph<3>(file, "f.g2o");
    FAIL();
  } catch (const InputError& error) {
    EXPECT_THAT(error.what(), testing::HasSubstr("1 of 2 information matrices are indefinite"));
  }
  G2oConversionOptions options;
  options.information = InformationUse::kNearest;
  const PoseGraph3 graph = MakePoseGraph<3>(file, "f.g2o", options);
  const Eigen::SelfAdjointEigenSolver<PoseInformation<3>> solver(graph.edges[1].information);
  EXPECT_GT(solver.eigenvalues()[0], -1e-12);
  EXPECT_LT((graph.edges[0].information - file.edges3[0].information).norm(), 1e-12);
}

TEST(MakePoseGraph, RefusesWhatIsNoGraph) {
  G2oGraph mixed = TwoPoses();
  mixed.vertices2.push_back({1, {}});
  EXPECT_THROW(IsPlanar(mixed, "f.g2o"), InputError);
  G2oGraph no_edges = TwoPoses();
  no_edges.edges3.clear();
  EXPECT_THROW(IsPlanar(no_edges, "f.g2o"), InputError);
  G2oGraph loop = TwoPoses();
  loop.edges3[0].to = 4;
  EXPECT_THROW(MakePoseGraph<3>(loop, "f.g2o"), InputError);
}

// Two priors without any edge between them would do; the edge then shares the contradiction.
TEST(MakePoseGraph, PriorsHoldThePosesInTheWorld) {
  G2oGraph file;
  file.vertices2 = {{0, {5.0, 5.0, 1.0}}, {1, {-3.0, 0.0, 2.0}}};
  G2oEdge2 edge;
  edge.from = 0;
  edge.to = 1;
  edge.measurement = {1.3, 0.0, 0.0};
  file.edges2 = {edge};
  file.priors2 = {{0, {0.0, 0.0, 0.0}, Eigen::Matrix3d::Identity()},
                  {1, {1.0, 0.0, 0.0}, Eigen::Matrix3d::Identity()}};
  PoseGraph2 graph = MakePoseGraph<2>(file, "f.g2o");
  ASSERT_TRUE(OptimizePoseGraph(&graph).converged);
  StorePoses(graph, &file);
  // x_0 and x_1 - 1 and x_1 - x_0 - 1.3 have least squares at -0.1, 1.1.
  EXPECT_NEAR(file.vertices2[0].pose.x, -0.1, 1e-9);
  EXPECT_NEAR(file.vertices2[1].pose.x, 1.1, 1e-9);
  EXPECT_NEAR(file.vertices2[1].pose.angle, 0.0, 1e-9);
}

}  // namespace
}  // namespace planegraph
