#include "planegraph/simulation/odometry.h"

#include <gtest/gtest.h>

#include <cmath>

#include "planegraph/geometry/rotation.h"

namespace planegraph {
namespace {

// A drive along x with a turn, which does not start at the origin.
std::vector<Rigid3> Drive(int count) {
  std::vector<Rigid3> poses;
  for (int k = 0; k < count; ++k) {
    poses.emplace_back(ExpSO3({0.02, -0.01, 0.05 * k}),
                       Eigen::Vector3d(5.0 + 2.0 * k, 0.1 * k, 1.0));
  }
  return poses;
}

OdometryOptions PerfectOdometry() { return {0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0}; }

TEST(OdometryTest, WithoutErrorsIsTheTruthSeenFromTheFirstPose) {
  const auto truth = Drive(6);
  Random random(1);
  const auto odometry = SimulateOdometry(truth, PerfectOdometry(), &random);
  ASSERT_EQ(odometry.size(), truth.size());
  for (std::size_t k = 0; k < truth.size(); ++k) {
    const Rigid3 expected = truth[0].Inverse() * truth[k];
    EXPECT_LT((odometry[k].translation - expected.translation).norm(), 1e-12);
    EXPECT_LT(AngleBetween(odometry[k].rotation, expected.rotation), 1e-7);
  }
}

TEST(OdometryTest, ScaleErrorLengthensOrShortensEveryStep) {
  OdometryOptions options = PerfectOdometry();
  options.scale_min = options.scale_max = 0.015;
  int longer = 0;
  for (std::uint64_t seed = 0; seed < 40; ++seed) {
    Random random(seed);
    const auto odometry = SimulateOdometry(Drive(2), options, &random);
    const double ratio = odometry[1].translation.norm() / std::sqrt(4.01);
    EXPECT_NEAR(std::abs(ratio - 1.0), 0.015, 1e-12);
    longer += ratio > 1.0;
  }
  EXPECT_GT(longer, 5);
  EXPECT_LT(longer, 35);
}

TEST(OdometryTest, StepErrorsHaveTheirSigmas) {
  OdometryOptions options = PerfectOdometry();
  options.step_sigma = 0.01;
  options.forward_sigma = 0.02;
  options.tilt_sigma = 0.003;
  const auto truth = Drive(20001);
  Random random(3);
  const auto odometry = SimulateOdometry(truth, options, &random);
  Eigen::Vector3d squares = Eigen::Vector3d::Zero();
  double tilt = 0.0;
  for (std::size_t k = 1; k < truth.size(); ++k) {
    const Rigid3 step = odometry[k - 1].Inverse() * odometry[k];
    const Rigid3 exact = truth[k - 1].Inverse() * truth[k];
    squares += (step.translation - exact.translation).cwiseAbs2();
    tilt += LogSO3(exact.rotation.conjugate() * step.rotation).squaredNorm();
  }
  const double count = static_cast<double>(truth.size() - 1), length = std::sqrt(4.01);
  EXPECT_NEAR(std::sqrt(squares.x() / count), 0.01 + 0.02 * length, 0.02 * 0.05);
  EXPECT_NEAR(std::sqrt(squares.y() / count), 0.01, 0.01 * 0.03);
  EXPECT_NEAR(std::sqrt(squares.z() / count), 0.01, 0.01 * 0.03);
  EXPECT_NEAR(std::sqrt(tilt / count), 0.003 * std::sqrt(2.0), 0.003 * 0.05);
}

}  // namespace
}  // namespace planegraph
