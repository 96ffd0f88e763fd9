#include "planegraph/registration/registration.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "planegraph/segmentation/segmenter.h"
#include "planegraph/simulation/simulation.h"
#include "segmentation/ray_world.h"

namespace planegraph {
namespace {

using Vector6d = Eigen::Matrix<double, 6, 1>;

PlaneSet PlanesOf(const RayWorld& world, const Rigid3& pose, std::uint64_t seed,
                  double max_range = 40.0) {
  return SegmentPlanes(ScanWorld(world, pose, 40000, {0.005, 0.0}, seed, max_range).cloud).planes;
}

Vector6d PoseError(const Rigid3& found, const Rigid3& truth) {
  Vector6d error;
  error << found.translation - truth.translation,
      LogSO3(found.rotation * truth.rotation.conjugate());
  return error;
}

void ExpectWithinThreeSigma(const Refinement& found, const Rigid3& truth) {
  const Vector6d error = PoseError(found.target_from_source, truth);
  for (int k = 0; k < 6; ++k) {
    EXPECT_LE(std::abs(error[k]), 3.0 * std::sqrt(found.covariance(k, k))) << "component " << k;
  }
}

const Rigid3 kTargetPose = MakePose(0.4, -0.3, 1.3, 0.0);
const Rigid3 kSourcePose = MakePose(-0.9, 0.5, 1.4, 1.2, 0.02, 0.03);

TEST(Register, FindsTheTruthWithinThreeSigma) {
  for (std::uint64_t seed = 0; seed < 6; ++seed) {
    SCOPED_TRACE(seed);
    const RayWorld room = FurnishedRoom(seed);
    const PlaneSet target = PlanesOf(room, kTargetPose, 1), source = PlanesOf(room, kSourcePose, 2);
    const Registration found = Register(ScanModel(target), ScanModel(source));
    ASSERT_EQ(found.status, RegistrationStatus::kOk) << found.reason;
    ExpectWithinThreeSigma(found.refinement, kTargetPose.Inverse() * kSourcePose);
    const Vector6d error =
        PoseError(found.target_from_source(), kTargetPose.Inverse() * kSourcePose);
    EXPECT_LT(error.head<3>().norm(), 0.01);
    EXPECT_LT(error.tail<3>().norm(), 0.005);
    EXPECT_GE(found.refinement.correspondences.size(), 6u);
    EXPECT_TRUE(found.unobserved.empty());
  }
}

TEST(Register, AnOkPoseIsAtRest) {
  for (std::uint64_t seed = 0; seed < 4; ++seed) {
    SCOPED_TRACE(seed);
    const RayWorld room = FurnishedRoom(seed);
    const PlaneSet target = PlanesOf(room, kTargetPose, 1), source = PlanesOf(room, kSourcePose, 2);
    const ScanModel target_model(target), source_model(source);
    const Registration found = Register(target_model, source_model);
    ASSERT_EQ(found.status, RegistrationStatus::kOk) << found.reason;
    EXPECT_TRUE(found.refinement.converged);
    const Refinement again = RefinePose(target_model, source_model, found.target_from_source());
    const Vector6d move = PoseError(again.target_from_source, found.target_from_source());
    EXPECT_LT(move.norm(), 5e-4);
  }
}

TEST(Register, CorrespondencesAreTheSameSurfaces) {
  const RayWorld room = FurnishedRoom(1);
  const PlaneSet target = PlanesOf(room, kTargetPose, 1), source = PlanesOf(room, kSourcePose, 2);
  const Registration found = Register(ScanModel(target), ScanModel(source));
  const Rigid3 truth = kTargetPose.Inverse() * kSourcePose;
  for (const PlanePair& pair : found.refinement.correspondences) {
    const Plane moved = Transform(truth, source.planes[pair.source].plane);
    EXPECT_GT(moved.normal.dot(target.planes[pair.target].plane.normal), 0.97);
    EXPECT_LT(std::abs(moved.SignedDistance(target.planes[pair.target].centroid())), 0.3);
  }
}

TEST(Register, IdenticalScansAreAtTheIdentity) {
  const PlaneSet planes = PlanesOf(FurnishedRoom(3), kTargetPose, 1);
  const Registration found = Register(ScanModel(planes), ScanModel(planes));
  ASSERT_EQ(found.status, RegistrationStatus::kOk) << found.reason;
  EXPECT_LT(PoseError(found.target_from_source(), Rigid3()).norm(), 1e-4);
}

TEST(Register, SwappedScansGiveTheInverse) {
  const RayWorld room = FurnishedRoom(4);
  const PlaneSet target = PlanesOf(room, kTargetPose, 1), source = PlanesOf(room, kSourcePose, 2);
  const Registration there = Register(ScanModel(target), ScanModel(source));
  const Registration back = Register(ScanModel(source), ScanModel(target));
  ASSERT_EQ(there.status, RegistrationStatus::kOk) << there.reason;
  ASSERT_EQ(back.status, RegistrationStatus::kOk) << back.reason;
  const Vector6d loop = PoseError(back.target_from_source() * there.target_from_source(), Rigid3());
  EXPECT_LT(loop.head<3>().norm(), 0.006);
  EXPECT_LT(loop.tail<3>().norm(), 0.003);
}

TEST(Register, AMovedSourceMovesTheResult) {
  const RayWorld room = FurnishedRoom(5);
  RayScan scan = ScanWorld(room, kSourcePose, 40000, {0.005, 0.0}, 2);
  const PlaneSet target = PlanesOf(room, kTargetPose, 1), source = SegmentPlanes(scan.cloud).planes;
  const Rigid3 motion = MakePose(5.0, -3.0, 1.0, 2.5, 0.4, -0.2);
  for (auto& point : scan.cloud.points) point = (motion * point.cast<double>()).cast<float>();
  scan.cloud.viewpoint = motion.translation;
  const PlaneSet moved = SegmentPlanes(scan.cloud).planes;
  const Registration plain = Register(ScanModel(target), ScanModel(source));
  const Registration other = Register(ScanModel(target), ScanModel(moved));
  ASSERT_EQ(plain.status, RegistrationStatus::kOk) << plain.reason;
  ASSERT_EQ(other.status, RegistrationStatus::kOk) << other.reason;
  const Vector6d error = PoseError(other.target_from_source() * motion, plain.target_from_source());
  EXPECT_LT(error.head<3>().norm(), 0.01);
  EXPECT_LT(error.tail<3>().norm(), 0.004);
}

TEST(Register, ACorridorLeavesItsDirectionOpen) {
  RayWorld corridor;
  corridor.AddBox(Eigen::Vector3d::Zero(), {120.0, 2.4, 2.8}, 0.0, -1.0);
  const Rigid3 a = MakePose(0, 0.2, 1.2, 0.0), b = MakePose(1.5, -0.2, 1.2, 0.1);
  const PlaneSet target = PlanesOf(corridor, a, 1, 20.0), source = PlanesOf(corridor, b, 2, 20.0);
  const auto check = [](const Registration& found) {
    ASSERT_FALSE(found.unobserved.empty()) << ToString(found.status) << found.reason;
    EXPECT_GT(std::abs(found.unobserved[0].direction[0]), 0.999);
    EXPECT_TRUE(std::isnan(found.unobserved[0].sigma) || found.unobserved[0].sigma > 0.05);
  };
  const Registration found = Register(ScanModel(target), ScanModel(source));
  EXPECT_NE(found.status, RegistrationStatus::kOk);
  check(found);
  PosePrior guess{a.Inverse() * b, Matrix6d::Identity() * 0.01};
  guess.target_from_source.translation += Eigen::Vector3d(0.0, 0.1, 0.05);
  const Registration guided = RegisterFromGuess(ScanModel(target), ScanModel(source), guess);
  EXPECT_EQ(guided.status, RegistrationStatus::kDegenerate) << guided.reason;
  check(guided);
  EXPECT_NEAR(guided.target_from_source().translation.x(), 1.5, 0.05) << "stays with the guess";
  EXPECT_NEAR(guided.target_from_source().translation.y(), -0.4, 0.01) << "is seen";
  EXPECT_NEAR(guided.target_from_source().translation.z(), 0.0, 0.01) << "is seen";
}

TEST(Register, OtherRoomsAreNotTakenForThisOne) {
  RayWorld hexagon;
  for (int k = 0; k < 6; ++k) {
    const double angle = 1.0472 * k;
    const Eigen::Vector3d n(std::cos(angle), std::sin(angle), 0);
    hexagon.AddFace(3.5 * n + 1.5 * Eigen::Vector3d::UnitZ(), -n, 2.02, 1.5);
  }
  hexagon.AddFace({0, 0, 0}, Eigen::Vector3d::UnitZ(), 4.1, 4.1);
  const PlaneSet target = PlanesOf(FurnishedRoom(0), kTargetPose, 1);
  const PlaneSet source = PlanesOf(hexagon, MakePose(0.3, 0.2, 1.0, 0), 2);
  EXPECT_NE(Register(ScanModel(target), ScanModel(source)).status, RegistrationStatus::kOk);
}

TEST(Register, ASymmetricRoomIsAmbiguous) {
  const RayWorld room = EmptyRoom({8, 5, 3});
  const PlaneSet target = PlanesOf(room, MakePose(1.5, 0.7, 1.3, 0), 1);
  const PlaneSet source = PlanesOf(room, MakePose(-1.0, 0.4, 1.3, 0.5), 2);
  const Registration found = Register(ScanModel(target), ScanModel(source));
  EXPECT_EQ(found.status, RegistrationStatus::kAmbiguous) << found.reason;
  EXPECT_THAT(found.reason, testing::HasSubstr("another pose"));
}

// A part of the source fits into the target 10 m beside its place, by chance, and no other pose
// explains nearly as much; of the target's surfaces hardly any then lies in the source.
TEST(Register, WhatExplainsOneScanAloneIsNotOk) {
  SimulationOptions options;
  options.scene = SceneKind::kHall;
  options.scans = 6;
  options.seed = 3119;
  const SimulatedRobot robot = Simulate(options).robots[0];
  const auto planes = [&](std::size_t k) { return SegmentPlanes(robot.scans[k].cloud).planes; };
  const PlaneSet target = planes(3), source = planes(4);
  const Registration found = Register(ScanModel(target), ScanModel(source));
  const Rigid3 truth = robot.truth[3].Inverse() * robot.truth[4];
  EXPECT_TRUE(found.status != RegistrationStatus::kOk ||
              PoseError(found.target_from_source(), truth).norm() < 0.1)
      << found.quality;
  EXPECT_FALSE(found.reason.empty());
}

TEST(Register, EmptyScansFail) {
  const PlaneSet none, planes = PlanesOf(EmptyRoom({5, 4, 3}), MakePose(0, 0, 1.3, 0), 1);
  for (const auto& [target, source] : {std::pair(&none, &planes), std::pair(&planes, &none)}) {
    const Registration found = Register(ScanModel(*target), ScanModel(*source));
    EXPECT_EQ(found.status, RegistrationStatus::kFailed);
    EXPECT_FALSE(found.reason.empty());
  }
}

TEST(RegisterFromGuess, RefinesTheGuess) {
  const RayWorld room = FurnishedRoom(2);
  const PlaneSet target = PlanesOf(room, kTargetPose, 1), source = PlanesOf(room, kSourcePose, 2);
  const Rigid3 truth = kTargetPose.Inverse() * kSourcePose;
  PosePrior guess{truth, Matrix6d::Identity() * 0.01};
  guess.target_from_source.translation += Eigen::Vector3d(0.15, -0.1, 0.08);
  guess.target_from_source.rotation = ExpSO3({0.02, -0.02, 0.04}) * truth.rotation;
  const Registration found = RegisterFromGuess(ScanModel(target), ScanModel(source), guess);
  EXPECT_EQ(found.status, RegistrationStatus::kOk) << found.reason;
  ExpectWithinThreeSigma(found.refinement, truth);
}

TEST(RegisterFromGuess, AWrongGuessIsNotOk) {
  const RayWorld room = FurnishedRoom(2);
  const PlaneSet target = PlanesOf(room, kTargetPose, 1), source = PlanesOf(room, kSourcePose, 2);
  Rigid3 wrong = kTargetPose.Inverse() * kSourcePose;
  wrong.translation += Eigen::Vector3d(3.0, 2.0, 0.0);
  const Registration found =
      RegisterFromGuess(ScanModel(target), ScanModel(source), {wrong, Matrix6d::Identity() * 0.01});
  EXPECT_NE(found.status, RegistrationStatus::kOk);
}

}  // namespace
}  // namespace planegraph
