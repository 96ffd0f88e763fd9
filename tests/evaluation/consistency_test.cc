#include "planegraph/evaluation/consistency.h"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <Eigen/QR>
#include <cmath>
#include <limits>
#include <random>

#include "planegraph/base/chi_square.h"

namespace planegraph {
namespace {

class Draws {
 public:
  Eigen::VectorXd Vector(int size) {
    return Eigen::VectorXd::NullaryExpr(size, [&] { return normal_(rng_); });
  }
  Eigen::MatrixXd Covariance(int size) {
    const Eigen::MatrixXd a =
        Eigen::MatrixXd::NullaryExpr(size, size, [&] { return normal_(rng_); });
    return a * a.transpose() + 0.1 * Eigen::MatrixXd::Identity(size, size);
  }
  Eigen::VectorXd ErrorOf(const Eigen::MatrixXd& covariance) {
    return covariance.llt().matrixL() * Vector(static_cast<int>(covariance.rows()));
  }

 private:
  std::mt19937_64 rng_{7};
  std::normal_distribution<double> normal_;
};

TEST(Consistency, IsTheMahalanobisDistance) {
  Draws draws;
  const Eigen::MatrixXd covariance = draws.Covariance(6);
  const Eigen::VectorXd error = draws.Vector(6);
  const auto normalized = Normalize(error, covariance);
  ASSERT_TRUE(normalized);
  EXPECT_EQ(normalized->degrees, 6);
  EXPECT_NEAR(normalized->squared, error.dot(covariance.inverse() * error), 1e-9);
}

TEST(Consistency, DoesNotDependOnUnitsAndAxes) {
  Draws draws;
  const Eigen::MatrixXd covariance = draws.Covariance(6);
  const Eigen::VectorXd error = draws.Vector(6);
  const double squared = Normalize(error, covariance)->squared;
  const Eigen::VectorXd units = (Eigen::VectorXd(6) << 1e3, 1e3, 1e3, 1e-4, 1e-4, 57).finished();
  const Eigen::MatrixXd in_units = units.asDiagonal() * covariance * units.asDiagonal();
  EXPECT_NEAR(Normalize(units.cwiseProduct(error), in_units)->squared, squared, 1e-9 * squared);
  const Eigen::MatrixXd turn = draws.Covariance(6).householderQr().householderQ();
  EXPECT_NEAR(Normalize(turn * error, turn * covariance * turn.transpose())->squared, squared,
              1e-9 * squared);
}

TEST(Consistency, UnobservedAndHeldAxesDoNotCount) {
  Draws draws;
  const Eigen::MatrixXd small = draws.Covariance(2);
  const Eigen::VectorXd error = draws.Vector(2);
  Eigen::MatrixXd large = Eigen::MatrixXd::Zero(4, 4);
  large.topLeftCorner(2, 2) = small;
  large.row(2).setConstant(std::numeric_limits<double>::quiet_NaN());
  large.col(2).setConstant(std::numeric_limits<double>::quiet_NaN());
  const Eigen::VectorXd more = (Eigen::VectorXd(4) << error, 100.0, 0.0).finished();
  const auto normalized = Normalize(more, large);
  ASSERT_TRUE(normalized);
  EXPECT_EQ(normalized->degrees, 2);
  EXPECT_NEAR(normalized->squared, Normalize(error, small)->squared, 1e-12);
  EXPECT_FALSE(Normalize(Eigen::VectorXd::Ones(2), Eigen::MatrixXd::Zero(2, 2)));
  Eigen::MatrixXd indefinite(2, 2);
  indefinite << 1, 2, 2, 1;
  EXPECT_FALSE(Normalize(Eigen::VectorXd::Ones(2), indefinite));
}

// Draws of honest, of too small and of too large covariances. Shares of n have a sigma of at most
// 0.5 / sqrt(n).
TEST(Consistency, CoverageIsThatOfTheLevels) {
  Draws draws;
  constexpr int kCount = 4000;
  const Eigen::MatrixXd covariance = draws.Covariance(6);
  std::vector<NormalizedError> honest, small, large;
  for (int k = 0; k < kCount; ++k) {
    const Eigen::VectorXd error = draws.ErrorOf(covariance);
    honest.push_back(*Normalize(error, covariance));
    small.push_back(*Normalize(error, 0.25 * covariance));
    large.push_back(*Normalize(error, 4.0 * covariance));
  }
  const auto shares = Coverage(honest), less = Coverage(small), more = Coverage(large);
  for (std::size_t k = 0; k < shares.size(); ++k) {
    EXPECT_NEAR(shares[k], kCoverageLevels[k], 4.0 * 0.5 / std::sqrt(kCount));
    EXPECT_LT(less[k], shares[k]);
    EXPECT_GT(more[k], shares[k]);
  }
}

// Two errors of equal origin: known jointly they are nearly one.
TEST(Consistency, KnowsOfCorrelations) {
  Draws draws;
  const Eigen::MatrixXd one = draws.Covariance(6);
  Eigen::MatrixXd joint(12, 12);
  joint << one, one, one, 1.01 * one;
  double sum = 0.0;
  int in_band = 0;
  constexpr int kCount = 400;
  for (int k = 0; k < kCount; ++k) {
    const Eigen::VectorXd errors = draws.ErrorOf(joint);
    const std::vector<Eigen::VectorXd> each = {errors.head(6), errors.tail(6)};
    const auto consistency = MeasureConsistency(each, {one, 1.01 * one}, joint);
    ASSERT_TRUE(consistency && consistency->joint && consistency->band);
    EXPECT_EQ(consistency->all.degrees, 12);
    sum += consistency->Nees();
    in_band += consistency->Nees() >= (*consistency->band)[0] &&
                       consistency->Nees() <= (*consistency->band)[1]
                   ? 1
                   : 0;
    EXPECT_FALSE(MeasureConsistency(each, {one, 1.01 * one}, {})->band);
  }
  EXPECT_NEAR(sum / kCount, 1.0, 4.0 * std::sqrt(2.0 / 12.0 / kCount));
  EXPECT_NEAR(in_band / double(kCount), 0.95, 4.0 * std::sqrt(0.95 * 0.05 / kCount));
}

TEST(Consistency, NothingComesOfNothing) {
  EXPECT_FALSE(MeasureConsistency({}, {}, {}));
  EXPECT_FALSE(MeasureConsistency({Eigen::VectorXd::Ones(6)}, {Eigen::MatrixXd::Zero(6, 6)}, {}));
}

}  // namespace
}  // namespace planegraph
