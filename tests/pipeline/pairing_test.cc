#include <gmock/gmock.h>

#include "planegraph/base/angles.h"
#include "planegraph/geometry/rotation.h"
#include "planegraph/pipeline/chain.h"
#include "planegraph/pipeline/joint_solve.h"

namespace planegraph {
namespace {

using ::testing::ElementsAre;

PairRecord Pair(std::size_t target, std::size_t source, bool used = true) {
  PairRecord pair{target, source, {}, used, 0.0};
  pair.registration.status = RegistrationStatus::kOk;
  return pair;
}

TEST(Components, EachScanAloneWithoutPairs) {
  EXPECT_THAT(Components(3, {}), ElementsAre(0, 1, 2));
  EXPECT_TRUE(Components(0, {}).empty());
}

TEST(Components, OnlyUsedPairsJoin) {
  EXPECT_THAT(Components(4, {Pair(0, 1), Pair(1, 2, false), Pair(2, 3)}), ElementsAre(0, 0, 1, 1));
}

TEST(Components, AreNumberedByTheirFirstScans) {
  EXPECT_THAT(Components(6, {Pair(3, 5), Pair(0, 4), Pair(5, 1)}), ElementsAre(0, 1, 2, 1, 0, 1));
  // The order of the pairs and which scan is the target do not matter.
  EXPECT_THAT(Components(6, {Pair(1, 5), Pair(4, 0), Pair(5, 3)}), ElementsAre(0, 1, 2, 1, 0, 1));
}

TEST(Components, ALongChainIsOne) {
  std::vector<PairRecord> chain;
  for (std::size_t i = 999; i > 0; --i) chain.push_back(Pair(i - 1, i));
  for (const int component : Components(1000, chain)) EXPECT_EQ(component, 0);
}

TEST(OdometryCovariance, GrowsWithTheWay) {
  const Matrix6d standing = OdometryCovariance({});
  const Matrix6d moved = OdometryCovariance({Eigen::Quaterniond::Identity(), {2, 0, 0}});
  const Matrix6d turned = OdometryCovariance({ExpSO3({0, 0, 1}), {0, 0, 0}});
  EXPECT_GT(standing.diagonal().minCoeff(), 0.0);
  EXPECT_GT(moved(0, 0), standing(0, 0));
  EXPECT_GT(moved(5, 5), standing(5, 5));
  EXPECT_GT(turned(5, 5), standing(5, 5));
}

Site TwoRobots() {
  Site site;
  for (const char* name : {"a", "b"}) {
    RobotSite robot;
    robot.name = name;
    robot.scans = {"0", "1"};
    Trajectory way;
    way.times = {0, 1};
    way.poses = {{ExpSO3({0, 0, 1}), {5, 5, 0}}, {ExpSO3({0, 0, 1.5}), {6, 5, 0}}};
    robot.odometry = way;
    site.robots.push_back(robot);
  }
  return site;
}

std::vector<ScanRecord> Records(const Site& site) {
  std::vector<ScanRecord> scans;
  for (std::size_t r = 0; r < site.robots.size(); ++r) {
    for (std::size_t i = 0; i < site.robots[r].scans.size(); ++i) {
      scans.emplace_back();
      scans.back().robot = r;
      scans.back().index = i;
    }
  }
  return scans;
}

TEST(OdometrySteps, StayWithinARobot) {
  const Site site = TwoRobots();
  const auto steps = OdometrySteps(site, Records(site));
  ASSERT_EQ(steps.size(), 2u);
  EXPECT_EQ(steps[0].target, 0u);
  EXPECT_EQ(steps[0].source, 1u);
  EXPECT_EQ(steps[1].target, 2u);
  EXPECT_EQ(steps[1].source, 3u);
  // One metre along the world's x is, for a robot that is turned by 1 rad, one metre at -1 rad.
  const Eigen::Vector3d expected(std::cos(-1.0), std::sin(-1.0), 0);
  EXPECT_LT((steps[0].target_from_source.translation - expected).norm(), 1e-12);
  EXPECT_NEAR(LogSO3(steps[0].target_from_source.rotation).z(), 0.5, 1e-12);
}

TEST(OdometrySteps, NoneWithoutOdometry) {
  Site site = TwoRobots();
  site.robots[0].odometry.reset();
  const auto steps = OdometrySteps(site, Records(site));
  ASSERT_EQ(steps.size(), 1u);
  EXPECT_EQ(steps[0].target, 2u);
}

// Steps of a metre, and registrations that differ from them by so many of their sigmas on each
// axis.
struct Steps {
  std::vector<OdometryStep> steps;
  std::vector<PairRecord> pairs;
};
Steps MakeRun(double sigmas_translation, double sigmas_rotation) {
  Steps run;
  for (std::size_t i = 0; i < 5; ++i) {
    const Rigid3 step(Eigen::Quaterniond::Identity(), {1, 0, 0});
    run.steps.push_back({i, i + 1, step, OdometryCovariance(step)});
    const Eigen::Matrix<double, 6, 1> sigma = run.steps[i].covariance.diagonal().cwiseSqrt();
    run.pairs.push_back(Pair(i, i + 1));
    run.pairs[i].registration.refinement.target_from_source = {
        ExpSO3(sigmas_rotation * sigma.tail<3>()),
        step.translation + sigmas_translation * sigma.head<3>()};
  }
  return run;
}

TEST(CalibrateOdometry, NeverScalesDown) {
  Steps run = MakeRun(0.1, 0.1);
  const Matrix6d before = run.steps[0].covariance;
  CalibrateOdometry(run.pairs, &run.steps);
  EXPECT_EQ(run.steps[0].covariance, before);
}

TEST(CalibrateOdometry, ScalesTranslationAndRotationByThemselves) {
  Steps run = MakeRun(4.0, 0.5);
  const Matrix6d before = run.steps[0].covariance;
  CalibrateOdometry(run.pairs, &run.steps);
  // The squared error is 16 times the variance in every step; its expectation at the median of
  // chi-square with three degrees of freedom is 2.366 / 3 of the variance.
  EXPECT_NEAR(run.steps[3].covariance(0, 0) / before(0, 0), 16.0 / (2.366 / 3), 0.1);
  EXPECT_EQ(run.steps[3].covariance(5, 5), before(5, 5));
  run = MakeRun(0.5, 4.0);
  CalibrateOdometry(run.pairs, &run.steps);
  EXPECT_EQ(run.steps[3].covariance(0, 0), before(0, 0));
  EXPECT_NEAR(run.steps[3].covariance(5, 5) / before(5, 5), 16.0 / (2.366 / 3), 0.1);
}

TEST(CalibrateOdometry, OneWrongRegistrationDoesNotMatter) {
  Steps run = MakeRun(0.5, 0.5);
  run.pairs[2].registration.refinement.target_from_source = {ExpSO3({0, 0, 3}), {40, 0, 0}};
  const Matrix6d before = run.steps[0].covariance;
  CalibrateOdometry(run.pairs, &run.steps);
  EXPECT_EQ(run.steps[0].covariance, before);
}

TEST(CalibrateOdometry, AsksOnlyPairsThatAreUsedAndObserved) {
  Steps run = MakeRun(20.0, 20.0);
  for (std::size_t i = 0; i < run.pairs.size(); ++i) {
    run.pairs[i].used = i % 2 == 0;
    if (i % 2 == 0) run.pairs[i].registration.status = RegistrationStatus::kDegenerate;
  }
  const Matrix6d before = run.steps[0].covariance;
  CalibrateOdometry(run.pairs, &run.steps);
  EXPECT_EQ(run.steps[0].covariance, before);
}

TEST(ChainPoses, FollowsRegistrationsAndElseTheOdometry) {
  Site site = TwoRobots();
  site.robots[1].start = StartPose{{ExpSO3({0, 0, 90 * kDegree}), {10, 0, 0}}};
  const auto scans = Records(site);
  std::vector<PairRecord> pairs = {Pair(0, 1)};
  pairs[0].registration.refinement.target_from_source.translation = {0.9, 0, 0};
  const auto odometry = OdometrySteps(site, scans);
  const auto poses = ChainPoses(site, scans, pairs, odometry);
  EXPECT_LT(poses[0].translation.norm(), 1e-15);
  EXPECT_LT((poses[1].translation - Eigen::Vector3d(0.9, 0, 0)).norm(), 1e-12);
  EXPECT_EQ(poses[2].translation, Eigen::Vector3d(10, 0, 0));
  const Rigid3 expected = poses[2] * odometry[1].target_from_source;
  EXPECT_LT((poses[3].translation - expected.translation).norm(), 1e-12);
  EXPECT_LT(AngleBetween(poses[3].rotation, expected.rotation), 1e-9);
  pairs[0].used = false;
  const auto without = ChainPoses(site, scans, pairs, odometry);
  EXPECT_LT((without[1].translation - odometry[0].target_from_source.translation).norm(), 1e-12);
}

}  // namespace
}  // namespace planegraph
