#include "planegraph/evaluation/trajectory_warnings.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <random>

#include "evaluation/curve.h"
#include "planegraph/base/error.h"
#include "planegraph/geometry/rotation.h"

namespace planegraph {
namespace {

using ::testing::Contains;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Not;

const std::string kData = PLANEGRAPH_SHARED_DATA;

Trajectory Noisy(Trajectory trajectory, double metres, double radians) {
  std::mt19937 random(7);
  std::normal_distribution<double> noise;
  const auto draw = [&]() { return Eigen::Vector3d(noise(random), noise(random), noise(random)); };
  for (Rigid3& pose : trajectory.poses) {
    pose.rotation = (pose.rotation * ExpSO3(radians * draw())).normalized();
    pose.translation += metres * draw();
  }
  return trajectory;
}

// What 3DTK's frames2tum makes of the poses, read as TUM: the columns qx qy qz qw hold -w x y z.
Trajectory Frames2tum(Trajectory trajectory) {
  for (Rigid3& pose : trajectory.poses) {
    const Eigen::Quaterniond q = pose.rotation;
    pose.rotation.coeffs() = Eigen::Vector4d(-q.w(), q.x(), q.y(), q.z());
  }
  return trajectory;
}

std::vector<std::string> Paired(const Trajectory& reference, const Trajectory& estimate) {
  return PairingWarnings(reference, "REF", estimate, "EST", PairPoses(reference, estimate, 0.02));
}

void ExpectFrames2tumIsSeen(const Trajectory& reference, const Trajectory& estimate,
                            const std::string& what) {
  EXPECT_THAT(Paired(reference, estimate), Not(Contains(HasSubstr("quaternions are read"))))
      << what;
  EXPECT_THAT(Paired(reference, Frames2tum(estimate)),
              Contains(::testing::AllOf(HasSubstr("EST"), HasSubstr("frames2tum"))))
      << what;
  EXPECT_THAT(Paired(Frames2tum(reference), estimate),
              Contains(::testing::AllOf(HasSubstr("REF"), HasSubstr("frames2tum"))))
      << what;
}

TEST(Warnings, Frames2tumIsSeenAndCleanFilesAreNot) {
  for (double radians : {0.0, 0.01, 0.1}) {
    const Trajectory curve = Curve(80);
    ExpectFrames2tumIsSeen(curve, Noisy(curve, 0.05, radians), "curve");
  }
  const Trajectory gentle = Curve(30, 0.2);
  ExpectFrames2tumIsSeen(gentle, Noisy(gentle, 0.05, 0.002), "gentle curve");
}

TEST(Warnings, Frames2tumOfPublishedTrajectories) {
  const std::pair<const char*, const char*> files[] = {
      {"/trajectories/freiburg1_xyz-groundtruth.txt", "/trajectories/freiburg1_xyz-rgbdslam.txt"},
      {"/hybrid-site-a/ugv/short/truth.tum", "/hybrid-site-a/ugv/short/odometry.tum"},
      {"/hybrid-site-a/ugv/loop/truth.tum", "/hybrid-site-a/ugv/loop/odometry.tum"},
      {"/bedkowski_tls13/reference_icp.tum", "/bedkowski_tls13/initial.tum"},
      {"/3dtk_dat/reference_slam6d_plain.tum", "/3dtk_dat/reference_slam6d_p2pl_full.tum"}};
  if (!std::filesystem::exists(kData)) GTEST_SKIP() << "the trajectories are not here";
  for (const auto& [reference, estimate] : files) {
    ExpectFrames2tumIsSeen(ReadTrajectory(kData + reference), ReadTrajectory(kData + estimate),
                           estimate);
    EXPECT_THAT(FileWarnings(ReadTrajectory(kData + estimate), "EST"), IsEmpty()) << estimate;
  }
}

TEST(Warnings, IdentityWithWFirst) {
  const Trajectory curve = Curve(5);  // starts with the identity
  EXPECT_THAT(FileWarnings(curve, "EST"), IsEmpty());
  EXPECT_THAT(FileWarnings(Frames2tum(curve), "EST"), Contains(HasSubstr("1 0 0 0")));
}

// The first quaternion tells which of two files is the wrong one; 3DTK's poses have no quaternions.
TEST(Warnings, NamesTheSuspect) {
  Trajectory curve = Curve(40);
  EXPECT_THAT(Paired(curve, Frames2tum(curve)), Contains(::testing::StartsWith("EST: ")));
  EXPECT_THAT(Paired(Frames2tum(curve), curve), Contains(::testing::StartsWith("REF: ")));
  Trajectory frames = curve;
  frames.has_times = false;
  EXPECT_THAT(Paired(frames, Frames2tum(curve)), Contains(::testing::StartsWith("EST: ")));
  EXPECT_THAT(Paired(Frames2tum(curve), frames), Contains(::testing::StartsWith("REF: ")));
  for (Rigid3& pose : curve.poses) pose.rotation = ExpSO3({0.5, 0.3, 0.9}) * pose.rotation;
  EXPECT_THAT(Paired(curve, Frames2tum(curve)), Contains(::testing::StartsWith("EST or REF: ")));
}

TEST(Warnings, OtherReadings) {
  const Trajectory curve = Curve(60);
  Trajectory inverted = curve, w_first = curve;
  for (Rigid3& pose : inverted.poses) pose.rotation = pose.rotation.conjugate();
  for (Rigid3& pose : w_first.poses) {
    const Eigen::Quaterniond q = pose.rotation;
    pose.rotation.coeffs() = Eigen::Vector4d(q.w(), q.x(), q.y(), q.z());
  }
  EXPECT_THAT(Paired(curve, inverted), Contains(HasSubstr("inverted (body from world")));
  EXPECT_THAT(Paired(curve, w_first), Contains(HasSubstr("read w first;")));
}

TEST(Warnings, TimesAndNorms) {
  Trajectory trajectory = Curve(5);
  std::swap(trajectory.times[2], trajectory.times[3]);
  trajectory.norm_error = 5e-3;
  const auto warnings = FileWarnings(trajectory, "EST");
  EXPECT_THAT(warnings, Contains(HasSubstr("EST: 1 times do not increase, first that of pose 3")));
  EXPECT_THAT(warnings, Contains(HasSubstr("not normalized")));
  trajectory.has_times = false;
  trajectory.norm_error = 5e-4;
  EXPECT_THAT(FileWarnings(trajectory, "EST"), IsEmpty());
}

TEST(Warnings, ManyUnpaired) {
  const Trajectory reference = Curve(50);
  Trajectory estimate = reference;
  for (std::size_t i = 0; i < 10; ++i) estimate.times[i] -= 500.0;
  EXPECT_THAT(Paired(reference, estimate), Contains(HasSubstr("10 of 50 poses")));
  EXPECT_THAT(Paired(reference, reference), IsEmpty());
}

std::vector<std::string> Placed(const Trajectory& reference, double metres,
                                PoseAlignment alignment = PoseAlignment::kSe3) {
  const PosePairs pairs = PairPoses(reference, Noisy(reference, metres, 0.0));
  return PlacementWarnings(pairs, ComputeAte(pairs, alignment));
}

TEST(Warnings, Places) {
  EXPECT_THAT(Placed(Curve(60), 0.02), IsEmpty());
  EXPECT_THAT(Placed(Curve(7), 0.001), Contains(HasSubstr("takes 6 of their 21 coordinates")));
  EXPECT_THAT(Placed(Curve(7), 0.001, PoseAlignment::kFirst), Contains(HasSubstr("too few")));
  EXPECT_THAT(Placed(Curve(60), 5.0, PoseAlignment::kFirst), Contains(HasSubstr("clustered")));
  Trajectory line = Curve(60);
  for (std::size_t i = 0; i < 60; ++i) {
    line.poses[i].translation = {0.5 * static_cast<double>(i), 0.2 * std::sin(0.7 * i), 0.0};
  }
  EXPECT_THAT(Placed(line, 0.05), Contains(HasSubstr("nearly lie on a line")));
  EXPECT_THAT(Placed(line, 0.05, PoseAlignment::kFirst), IsEmpty());
  Trajectory standing = Curve(60);
  for (std::size_t i = 0; i < 40; ++i) standing.poses[i].translation = {3.0, 0.0, 0.0};
  EXPECT_THAT(Placed(standing, 0.001), Contains(HasSubstr("40 of 60 poses stand")));
}

}  // namespace
}  // namespace planegraph
