#include "planegraph/evaluation/trajectory_error.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "evaluation/curve.h"
#include "planegraph/base/error.h"
#include "planegraph/geometry/rotation.h"

namespace planegraph {
namespace {

using Pairs = std::vector<std::pair<std::size_t, std::size_t>>;

// A straight path along x with the given positions and no rotation.
Trajectory Straight(const std::vector<double>& positions) {
  Trajectory trajectory;
  for (double x : positions) {
    trajectory.times.push_back(static_cast<double>(trajectory.size()));
    trajectory.poses.emplace_back(Eigen::Quaterniond::Identity(), Eigen::Vector3d(x, 0, 0));
  }
  return trajectory;
}

Trajectory Noisy(Trajectory trajectory) {
  std::mt19937 random(7);
  std::normal_distribution<double> noise(0.0, 0.05);
  for (Rigid3& pose : trajectory.poses) {
    const Eigen::Vector3d turn(noise(random), noise(random), noise(random));
    pose.rotation = (pose.rotation * ExpSO3(turn)).normalized();
    pose.translation += Eigen::Vector3d(noise(random), noise(random), noise(random));
  }
  return trajectory;
}

Trajectory Moved(const Sim3& b_from_a, Trajectory trajectory) {
  for (Rigid3& pose : trajectory.poses) {
    pose = {(b_from_a.rotation * pose.rotation).normalized(), b_from_a * pose.translation};
  }
  return trajectory;
}

const Sim3 kMotion(1.0, ExpSO3({0.4, -1.1, 2.0}), {10.0, -20.0, 5.0});
const Sim3 kSimilarity(1.7, ExpSO3({0.4, -1.1, 2.0}), {10.0, -20.0, 5.0});

double AteRmse(const Trajectory& reference, const Trajectory& estimate, PoseAlignment alignment) {
  return ComputeAte(PairPoses(reference, estimate), alignment).errors.translation.rmse;
}

TEST(Ate, PerfectEstimateIsZeroUnderEveryAlignment) {
  const Trajectory curve = Curve(50);
  for (const char* name : {"se3", "sim3", "first", "none"}) {
    const auto ate = ComputeAte(PairPoses(curve, curve), ParsePoseAlignment(name));
    EXPECT_LT(ate.errors.translation.max, 1e-12) << name;
    EXPECT_LT(ate.errors.rotation.max, 1e-12) << name;
    EXPECT_EQ(ate.errors.count, 50u);
  }
}

TEST(Ate, Se3IgnoresRigidMotionOfTheEstimate) {
  const Trajectory reference = Curve(60), estimate = Noisy(reference);
  const double error = AteRmse(reference, estimate, PoseAlignment::kSe3);
  EXPECT_GT(error, 0.05);
  EXPECT_NEAR(AteRmse(reference, Moved(kMotion, estimate), PoseAlignment::kSe3), error, 1e-12);
}

TEST(Ate, Sim3RecoversTheSimilarity) {
  const Trajectory reference = Curve(60), estimate = Moved(kSimilarity, reference);
  const auto ate = ComputeAte(PairPoses(reference, estimate), PoseAlignment::kSim3);
  EXPECT_LT(ate.errors.translation.max, 1e-10);
  EXPECT_NEAR(ate.reference_from_estimate.scale, 1.0 / 1.7, 1e-12);
  EXPECT_GT(AteRmse(reference, estimate, PoseAlignment::kSe3), 0.5);
}

TEST(Ate, FirstMakesTheFirstPosesEqual) {
  const Trajectory reference = Curve(60), estimate = Moved(kMotion, reference);
  EXPECT_LT(AteRmse(reference, estimate, PoseAlignment::kFirst), 1e-12);
  const auto noisy = ComputeAte(PairPoses(reference, Noisy(estimate)), PoseAlignment::kFirst);
  EXPECT_LT(noisy.errors.translation_errors[0], 1e-12);
  EXPECT_LT(noisy.errors.rotation_errors[0], 1e-12);
}

TEST(Ate, KnownOffsetAndAngle) {
  const Trajectory reference = Curve(20);
  Trajectory estimate = reference;
  for (Rigid3& pose : estimate.poses) {
    pose.translation += Eigen::Vector3d(3.0, 0.0, 4.0);
    pose.rotation = pose.rotation * ExpSO3({0.0, 0.25, 0.0});
  }
  const auto ate = ComputeAte(PairPoses(reference, estimate), PoseAlignment::kNone);
  EXPECT_NEAR(ate.errors.translation.rmse, 5.0, 1e-12);
  EXPECT_NEAR(ate.errors.translation.std, 0.0, 1e-12);
  EXPECT_NEAR(ate.errors.rotation.mean, 0.25, 1e-12);
}

TEST(Ate, PositionsOnALineHaveNoAlignment) {
  const Trajectory line = Straight({0.0, 1.0, 2.5, 3.0});
  for (auto alignment : {PoseAlignment::kSe3, PoseAlignment::kSim3}) {
    try {
      ComputeAte(PairPoses(line, line), alignment);
      ADD_FAILURE() << "aligned " << Name(alignment);
    } catch (const NoResultError& error) {
      EXPECT_NE(std::string(error.what()).find("line"), std::string::npos);
    }
  }
  EXPECT_EQ(AteRmse(line, line, PoseAlignment::kFirst), 0.0);
}

TEST(Ate, NearlyALineWithinTheMisfitHasNoAlignment) {
  Trajectory reference = Straight({0.0, 1.6, 3.4}), estimate = reference;
  reference.poses[1].translation.y() = 0.01;
  estimate.poses[1].translation.z() = 0.01;
  EXPECT_THROW(AteRmse(reference, estimate, PoseAlignment::kSe3), NoResultError);
}

TEST(Ate, OnePoseHasNoAlignment) {
  EXPECT_THROW(AteRmse(Curve(1), Curve(1), PoseAlignment::kSe3), NoResultError);
}

TEST(PairPoses, ByTimeTakesTheNearestWithinTheLimit) {
  const Trajectory reference = Curve(30);
  Trajectory estimate;
  for (std::size_t i : {3u, 7u, 20u}) {
    estimate.times.push_back(reference.times[i] + 0.004);
    estimate.poses.push_back(reference.poses[i]);
  }
  estimate.times.push_back(reference.times[25] + 0.05);
  estimate.poses.push_back(reference.poses[25]);
  const PosePairs pairs = PairPoses(reference, estimate, 0.01);
  ASSERT_EQ(pairs.reference.size(), 3u);
  EXPECT_NEAR(pairs.max_time_difference, 0.004, 1e-9);
  for (std::size_t k = 0; k < 3; ++k) {
    EXPECT_LT((pairs.reference[k].translation - pairs.estimate[k].translation).norm(), 1e-12);
  }
}

TEST(PairPoses, SwappedRolesGiveTheSamePairs) {
  const Trajectory many = Curve(30);
  Trajectory few = Curve(9);
  const PosePairs forth = PairPoses(many, few), back = PairPoses(few, many);
  ASSERT_EQ(forth.reference.size(), 9u);
  ASSERT_EQ(back.estimate.size(), 9u);
  EXPECT_EQ(forth.reference[4].translation, back.estimate[4].translation);
}

TEST(PairPoses, UnequalCountsWithoutTimesAreAnInputError) {
  Trajectory reference = Curve(5), estimate = Curve(4);
  estimate.has_times = false;
  try {
    PairPoses(reference, estimate, 0.01, "poses.txt");
    ADD_FAILURE();
  } catch (const InputError& error) {
    EXPECT_EQ(error.file(), "poses.txt");
    EXPECT_NE(error.reason().find("4 poses"), std::string::npos);
  }
}

TEST(PairPoses, NothingWithinTheLimitIsNoResult) {
  Trajectory late = Curve(5);
  for (double& t : late.times) t += 1000.0;
  EXPECT_THROW(PairPoses(Curve(5), late), NoResultError);
}

TEST(SelectPairs, Frames) {
  const auto poses = PairPoses(Curve(7), Curve(7)).reference;
  RpeOptions options;
  options.delta = 3;
  EXPECT_EQ(SelectPairs(poses, options), (Pairs{{0, 3}, {3, 6}}));
  options.all_pairs = true;
  EXPECT_EQ(SelectPairs(poses, options), (Pairs{{0, 3}, {1, 4}, {2, 5}, {3, 6}}));
}

TEST(SelectPairs, Metres) {
  const Trajectory line = Straight({0.0, 0.6, 1.2, 1.8, 2.2, 3.35, 4.0});
  const auto poses = PairPoses(line, line).reference;
  RpeOptions options;
  options.unit = DeltaUnit::kMetres;
  // Stops after 1.2, 2.2 and 3.35 m; the first pair begins at the first stop.
  EXPECT_EQ(SelectPairs(poses, options), (Pairs{{2, 4}, {4, 5}}));
  options.all_pairs = true;
  EXPECT_EQ(SelectPairs(poses, options), (Pairs{{2, 4}}));
  options.relative_tolerance = 0.21;
  EXPECT_EQ(SelectPairs(poses, options), (Pairs{{0, 2}, {1, 3}, {2, 4}, {4, 5}}));
}

TEST(SelectPairs, SenselessDeltaIsWrongUsage) {
  RpeOptions options;
  for (double delta : {0.0, -1.0, 1.5, std::nan("")}) {
    options.delta = delta;
    EXPECT_THROW(SelectPairs({}, options), UsageError) << delta;
  }
}

TEST(Rpe, IgnoresRigidMotionOfTheEstimate) {
  const Trajectory reference = Curve(40), estimate = Noisy(reference);
  const auto plain = ComputeRpe(PairPoses(reference, estimate), {}).errors;
  const auto moved = ComputeRpe(PairPoses(reference, Moved(kMotion, estimate)), {}).errors;
  EXPECT_EQ(plain.count, 39u);
  EXPECT_NEAR(plain.translation.rmse, moved.translation.rmse, 1e-12);
  EXPECT_NEAR(plain.rotation.max, moved.rotation.max, 1e-12);
}

TEST(Rpe, KnownDriftPerFrame) {
  Trajectory reference = Straight({0, 1, 2, 3, 4}), estimate = Straight({0, 1.1, 2.2, 3.3, 4.4});
  for (std::size_t i = 0; i < estimate.size(); ++i) {
    estimate.poses[i].rotation = ExpSO3({0.02 * static_cast<double>(i), 0.0, 0.0});
  }
  RpeOptions options;
  const auto one = ComputeRpe(PairPoses(reference, estimate), options).errors;
  EXPECT_NEAR(one.translation.mean, 0.1, 1e-12);
  EXPECT_NEAR(one.rotation.mean, 0.02, 1e-12);
  options.delta = 2;
  EXPECT_NEAR(ComputeRpe(PairPoses(reference, estimate), options).errors.translation.max, 0.2,
              1e-12);
  EXPECT_NEAR(ComputeRpe(PairPoses(reference, estimate), {}, 1 / 1.1).errors.translation.max, 0.0,
              1e-12);
}

TEST(Rpe, PairsAreChosenOnTheAskedPath) {
  const Trajectory reference = Straight({0, 1, 2, 3, 4, 5, 6}),
                   estimate = Straight({0, 0.5, 1, 1.5, 2, 2.5, 3});
  RpeOptions options;
  options.unit = DeltaUnit::kMetres;
  EXPECT_EQ(ComputeRpe(PairPoses(reference, estimate), options).errors.count, 5u);
  options.pairs_from_estimate = true;
  EXPECT_EQ(ComputeRpe(PairPoses(reference, estimate), options).errors.count, 2u);
}

TEST(Rpe, TooShortAPathIsNoResult) {
  RpeOptions options;
  options.delta = 100;
  EXPECT_THROW(ComputeRpe(PairPoses(Curve(5), Curve(5)), options), NoResultError);
}

}  // namespace
}  // namespace planegraph
