#include "planegraph/simulation/gps.h"

#include <gtest/gtest.h>

#include <cmath>

#include "planegraph/base/error.h"

namespace planegraph {
namespace {

using Eigen::Vector3d;

Flight StraightFlight(double seconds) {
  Flight flight;
  flight.times = {100.0, 100.0 + seconds};
  flight.world_from_camera = {Rigid3(Eigen::Quaterniond::Identity(), {0.0, 0.0, 20.0}),
                              Rigid3(Eigen::Quaterniond::Identity(), {seconds, 0.0, 20.0})};
  return flight;
}

GpsOptions PerfectGps() {
  GpsOptions options;
  options.bias_sigma = options.drift_sigma = options.white_sigma = Vector3d::Zero();
  options.outlier_share = 0.0;
  return options;
}

std::vector<Vector3d> Errors(const SimulatedGps& track, const Flight& flight) {
  std::vector<Vector3d> errors;
  for (std::size_t k = 0; k < track.times.size(); ++k) {
    errors.push_back(track.positions[k] - PositionAt(flight, track.times[k]));
  }
  return errors;
}

// Mean of e(t) e(t + lag), axis by axis.
Vector3d Covariance(const std::vector<Vector3d>& errors, std::size_t lag) {
  Vector3d sum = Vector3d::Zero();
  for (std::size_t k = 0; k + lag < errors.size(); ++k) {
    sum += errors[k].cwiseProduct(errors[k + lag]);
  }
  return sum / static_cast<double>(errors.size() - lag);
}

TEST(GpsTest, PositionsBetweenImagesLieOnTheLine) {
  const Flight flight = StraightFlight(10.0);
  EXPECT_LT((PositionAt(flight, 102.5) - Vector3d(2.5, 0.0, 20.0)).norm(), 1e-12);
  EXPECT_LT((PositionAt(flight, 0.0) - Vector3d(0.0, 0.0, 20.0)).norm(), 1e-12);
  EXPECT_LT((PositionAt(flight, 1e9) - Vector3d(10.0, 0.0, 20.0)).norm(), 1e-12);
}

TEST(GpsTest, WithoutErrorsOneFixASecondOnTheWay) {
  const Flight flight = StraightFlight(10.5);
  Random random(1);
  const SimulatedGps track = SimulateGps(flight, PerfectGps(), &random);
  ASSERT_EQ(track.times.size(), 11u);
  for (std::size_t k = 0; k < track.times.size(); ++k) {
    EXPECT_DOUBLE_EQ(track.times[k], 100.0 + static_cast<double>(k));
    EXPECT_LT((track.positions[k] - Vector3d(k, 0.0, 20.0)).norm(), 1e-9);
  }
}

TEST(GpsTest, DriftIsAGaussMarkovProcessBesideWhiteNoise) {
  const Flight flight = StraightFlight(200000.0);
  GpsOptions options;
  options.bias_sigma = Vector3d::Zero();
  options.outlier_share = 0.0;
  Random random(2);
  const auto errors = Errors(SimulateGps(flight, options, &random), flight);
  const Vector3d drift = options.drift_sigma.cwiseAbs2(), white = options.white_sigma.cwiseAbs2();
  // About 200000 / 80 independent values: the estimates are good to some per cent.
  EXPECT_LT(((Covariance(errors, 0) - drift - white).cwiseQuotient(drift + white)).norm(), 0.12);
  for (const std::size_t lag : {1, 20, 40}) {
    const Vector3d expected = drift * std::exp(-static_cast<double>(lag) / options.drift_time);
    EXPECT_LT((Covariance(errors, lag) - expected).cwiseQuotient(drift).norm(), 0.12) << lag;
  }
}

TEST(GpsTest, TheBiasIsConstantAndItsSpreadAsStated) {
  GpsOptions options = PerfectGps();
  options.bias_sigma = {1.0, 2.0, 3.0};
  const Flight flight = StraightFlight(3.0);
  Vector3d squares = Vector3d::Zero();
  constexpr int kRuns = 4000;
  for (int seed = 0; seed < kRuns; ++seed) {
    Random random(seed);
    const SimulatedGps track = SimulateGps(flight, options, &random);
    for (const Vector3d& error : Errors(track, flight)) {
      ASSERT_LT((error - track.bias).norm(), 1e-9);
    }
    squares += track.bias.cwiseAbs2() / kRuns;
  }
  EXPECT_LT((squares.cwiseSqrt() - options.bias_sigma).cwiseQuotient(options.bias_sigma).norm(),
            0.05);
}

TEST(GpsTest, AFewFixesAreFarOff) {
  GpsOptions options = PerfectGps();
  options.outlier_share = 0.02;
  const Flight flight = StraightFlight(20000.0);
  Random random(5);
  int far = 0;
  for (const Vector3d& error : Errors(SimulateGps(flight, options, &random), flight)) {
    far += error.norm() > 1e-6;
  }
  EXPECT_NEAR(far / 20001.0, 0.02, 0.004);
}

TEST(GpsTest, RefusesOptionsWithoutSense) {
  GpsOptions period, drift;
  period.period = 0.0;
  drift.drift_time = -1.0;
  Random random(0);
  EXPECT_THROW(SimulateGps(StraightFlight(1.0), period, &random), UsageError);
  EXPECT_THROW(SimulateGps(StraightFlight(1.0), drift, &random), UsageError);
  period.period = 1e-12;
  EXPECT_THROW(SimulateGps(StraightFlight(1.0), period, &random), UsageError);
  EXPECT_TRUE(SimulateGps(Flight(), GpsOptions(), &random).times.empty());
}

}  // namespace
}  // namespace planegraph
