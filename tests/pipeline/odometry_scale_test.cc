// One factor between the lengths of a robot's odometry and those of the registrations.
#include <gtest/gtest.h>

#include "planegraph/geometry/rotation.h"
#include "planegraph/pipeline/chain.h"
#include "planegraph/simulation/odometry.h"

namespace planegraph {
namespace {

constexpr double kScale = 1.02;

struct Walk {
  std::vector<PairRecord> chain;
  std::vector<OdometryStep> steps;
};

// Steps of 2 m in the direction of `heading` that registrations find kScale times as long.
Walk MakeWalk(std::size_t count, const Eigen::Vector3d& heading) {
  Walk walk;
  for (std::size_t i = 0; i < count; ++i) {
    OdometryStep step;
    step.target = i, step.source = i + 1;
    step.target_from_source.translation = 2.0 * heading;
    step.covariance = OdometryCovariance(step.target_from_source);
    step.sigma_scale = OdometryNoise().scale;
    walk.steps.push_back(step);
    PairRecord pair{i, i + 1, {}, true, 0.0};
    pair.registration.refinement.target_from_source.translation = kScale * 2.0 * heading;
    pair.registration.refinement.covariance = 1e-6 * Matrix6d::Identity();
    walk.chain.push_back(pair);
  }
  return walk;
}

void Open(const Eigen::Vector3d& axis, PairRecord* pair) {
  UnobservedDirection open;
  open.direction << axis, Eigen::Vector3d::Zero();
  pair->registration.unobserved.push_back(open);
}

TEST(OdometryScale, ComesFromTheRegistrationsAndItsPrior) {
  const OdometryNoise noise;
  double before = 1.0;
  for (const std::size_t count : {1, 10, 100}) {
    Walk walk = MakeWalk(count, Eigen::Vector3d::UnitX());
    const double variance = std::pow(noise.step + 2.0 * noise.per_metre, 2) + 1e-6;
    const double measured = static_cast<double>(count) * 4.0 / variance;
    const double prior = 1.0 / (noise.scale * noise.scale);
    const double scale = ScaleOdometry(walk.chain, 1, &walk.steps).front();
    EXPECT_NEAR(scale, (kScale * measured + prior) / (measured + prior), 1e-12);
    EXPECT_GT(scale, before);
    EXPECT_NEAR(walk.steps.back().target_from_source.translation.x(), 2.0 * scale, 1e-12);
    before = scale;
  }
  EXPECT_NEAR(before, kScale, 1e-3);
}

TEST(OdometryScale, DoesNotDependOnTheHeading) {
  Walk along_x = MakeWalk(5, Eigen::Vector3d::UnitX());
  Walk turned = MakeWalk(5, Eigen::Vector3d(0.3, -0.9, 0.1).normalized());
  EXPECT_NEAR(ScaleOdometry(along_x.chain, 1, &along_x.steps).front(),
              ScaleOdometry(turned.chain, 1, &turned.steps).front(), 1e-12);
}

TEST(OdometryScale, StaysWhereNothingIsSeenAlongTheWay) {
  const Eigen::Vector3d heading = Eigen::Vector3d(2, 1, 0).normalized();
  Walk walk = MakeWalk(20, heading);
  for (PairRecord& pair : walk.chain) Open(heading, &pair);
  EXPECT_NEAR(ScaleOdometry(walk.chain, 1, &walk.steps).front(), 1.0, 1e-12);
}

TEST(OdometryScale, AContradictionHasNoSay) {
  Walk walk = MakeWalk(20, Eigen::Vector3d::UnitX());
  Walk with_false = walk;
  with_false.chain[3].registration.refinement.target_from_source.translation.x() = -9.0;
  Walk without = walk;
  without.chain[3].used = false;
  EXPECT_DOUBLE_EQ(ScaleOdometry(with_false.chain, 1, &with_false.steps).front(),
                   ScaleOdometry(without.chain, 1, &without.steps).front());
}

TEST(OdometryScale, OfEachRobotIsItsOwn) {
  Walk walk = MakeWalk(10, Eigen::Vector3d::UnitX());
  Walk alone = walk;
  for (std::size_t k = 5; k < 10; ++k) {
    walk.steps[k].robot = 1;
    walk.chain[k].registration.refinement.target_from_source.translation.x() = 2.0;
  }
  alone.chain.resize(5);
  const auto scales = ScaleOdometry(walk.chain, 3, &walk.steps);
  EXPECT_NEAR(scales[0], ScaleOdometry(alone.chain, 1, &alone.steps).front(), 1e-12);
  EXPECT_NEAR(scales[1], 1.0, 1e-12);
  EXPECT_DOUBLE_EQ(scales[2], 1.0);  // without odometry
}

TEST(OdometryScale, IsOneWhereTheSiteSaysSo) {
  Walk walk = MakeWalk(20, Eigen::Vector3d::UnitX());
  for (OdometryStep& step : walk.steps) step.sigma_scale = 0.0;
  EXPECT_DOUBLE_EQ(ScaleOdometry(walk.chain, 1, &walk.steps).front(), 1.0);
}

// However little a step errs by on its own, beside a scale that is found to be larger than one.
TEST(OdometryScale, LeavesWhatAStepErrsByOnItsOwn) {
  Walk walk = MakeWalk(20, Eigen::Vector3d::UnitX());
  OdometryNoise exact;
  exact.step = 1e-4;
  exact.per_metre = 0.0;
  for (OdometryStep& step : walk.steps) {
    step.covariance = OdometryCovariance(step.target_from_source, exact);
  }
  const Matrix6d before = walk.steps[0].OwnCovariance();
  EXPECT_GT(ScaleOdometry(walk.chain, 1, &walk.steps).front(), 1.01);
  EXPECT_LT((walk.steps[0].OwnCovariance() - before).norm(), 1e-12);
}

// Own errors and the common one make the whole.
TEST(OdometryScale, TheCovarianceOfAStepFallsIntoTwoParts) {
  const Walk walk = MakeWalk(1, Eigen::Vector3d::UnitY());
  const Matrix6d own = walk.steps[0].OwnCovariance();
  const OdometryNoise noise;
  const double sigma = noise.step + 2.0 * noise.per_metre;
  EXPECT_NEAR((own.topLeftCorner<3, 3>() - sigma * sigma * Eigen::Matrix3d::Identity()).norm(), 0,
              1e-15);
  EXPECT_NEAR(walk.steps[0].covariance(1, 1) - own(1, 1), std::pow(2.0 * noise.scale, 2), 1e-15);
}

}  // namespace
}  // namespace planegraph
