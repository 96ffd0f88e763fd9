#include "planegraph/graph/graph.h"

#include <gtest/gtest.h>

#include "planegraph/geometry/rotation.h"
#include "planegraph/graph/factor_sampling.h"
#include "planegraph/graph/pose_error.h"

namespace planegraph {
namespace {

TEST(SquareRootInformation, GivesTheInformationBack) {
  std::mt19937_64 rng(1);
  for (int trial = 0; trial < 50; ++trial) {
    const Matrix6d information = FactorSampler(&rng).Information();
    const Matrix6d root = SquareRootInformation(information);
    EXPECT_LT((root.transpose() * root - information).norm(), 1e-9 * information.norm());
  }
}

TEST(SquareRootInformation, KeepsTheNullDirections) {
  Matrix6d information = Matrix6d::Zero();
  information(0, 0) = 1e8;
  information(4, 4) = 1e-2;
  const Matrix6d root = SquareRootInformation(information);
  EXPECT_LT((root.transpose() * root - information).norm(), 1e-7);
  EXPECT_EQ((root.rowwise().norm().array() > 0.0).count(), 2);
}

TEST(SquareRootInformation, RefusesIndefiniteMatrices) {
  Matrix6d information = Matrix6d::Identity();
  information(0, 1) = information(1, 0) = 2.0;
  EXPECT_THROW(SquareRootInformation(information), std::invalid_argument);
  information = -Matrix6d::Identity();
  EXPECT_THROW(SquareRootInformation(information), std::invalid_argument);
}

TEST(InverseLeftJacobian, IsTheDerivativeOfLog) {
  std::mt19937_64 rng(2);
  FactorSampler sampler(&rng);
  for (const double angle : {1e-9, 1e-4, 9e-4, 1.1e-3, 0.5, 2.0, 3.1}) {
    const Eigen::Vector3d phi = angle * sampler.UnitVector();
    Eigen::Matrix3d numeric;
    for (int k = 0; k < 3; ++k) {
      const Eigen::Vector3d step = 1e-6 * Eigen::Vector3d::Unit(k);
      numeric.col(k) =
          (LogSO3(ExpSO3(step) * ExpSO3(phi)) - LogSO3(ExpSO3(-step) * ExpSO3(phi))) / 2e-6;
    }
    EXPECT_LT((numeric - InverseLeftJacobian(phi)).norm(), 1e-8) << angle;
  }
}

TEST(MakePlaneObservation, WeightsAreInverseSigmasAndTheNormalIsTheSegments) {
  PlaneSegment segment;
  segment.id = 17;
  segment.plane = {-Eigen::Vector3d::UnitX(), -2.0};
  segment.moments.count = 50;
  segment.moments.mean = {2, 3, 4};
  segment.axes.vectors << 1, 0, 0, 0, 0, -1, 0, 1, 0;
  segment.covariance.diagonal() << 1e-4, 4e-4, 0.0;
  const PlaneObservation seen = MakePlaneObservation(3, segment);
  EXPECT_EQ(seen.pose, 3);
  EXPECT_EQ(seen.user_tag, 17);
  EXPECT_LT((seen.axes.col(0) - segment.plane.normal).norm(), 1e-15);
  EXPECT_NEAR(seen.axes.determinant(), 1.0, 1e-15);
  EXPECT_NEAR(seen.tilt_weight_1, 100.0, 1e-9);
  EXPECT_NEAR(seen.tilt_weight_2, 50.0, 1e-9);
  EXPECT_EQ(seen.offset_weight, 0.0);  // not known
}

TEST(FitLandmark, FindsThePlaneOfNoiseFreeObservations) {
  const Plane world{Eigen::Vector3d(1, 2, 2) / 3.0, 7.0};
  const auto basis = TangentBasis(world.normal);
  Graph graph;
  std::vector<PlaneObservation> observations;
  for (int i = 0; i < 3; ++i) {
    const Rigid3 pose(ExpSO3({0.3 * i, -0.5, 0.1}), {1.0 * i, 2, 3});
    graph.poses.push_back({"", pose});
    PlaneObservation seen;
    seen.pose = i;
    seen.centroid = pose.Inverse() * (world.distance * world.normal + i * basis.col(0));
    seen.axes << world.normal, basis;
    seen.axes = pose.rotation.conjugate().toRotationMatrix() * seen.axes;
    observations.push_back(seen);
  }
  PlaneLandmark plane = MakePlaneLandmark(graph, observations);
  plane.normal = (plane.normal + Eigen::Vector3d(0.2, -0.1, 0.3)).normalized();
  plane.offset += 1.0;
  FitLandmark(graph, &plane);
  EXPECT_LT((plane.WorldPlane().normal - world.normal).norm(), 1e-12);
  EXPECT_NEAR(plane.WorldPlane().distance, world.distance, 1e-12);
}

TEST(MakePlaneLandmark, NeedsAnObservation) {
  EXPECT_THROW(MakePlaneLandmark(Graph(), {}), std::invalid_argument);
}

}  // namespace
}  // namespace planegraph
