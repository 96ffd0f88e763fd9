#include "planegraph/graph/loss.h"

#include <gtest/gtest.h>

#include <cmath>

#include "planegraph/base/error.h"
#include "planegraph/graph/factor_losses.h"

namespace planegraph {
namespace {

double Rho(const ceres::LossFunction& loss, double s) {
  double rho[3];
  loss.Evaluate(s, rho);
  return rho[0];
}

class EveryLoss : public testing::TestWithParam<std::string> {};

TEST_P(EveryLoss, DerivativesAreThoseOfRho) {
  for (const double scale : {0.5, 1.0, 3.0}) {
    const auto loss = MakeLoss({GetParam(), scale});
    ASSERT_NE(loss, nullptr);
    for (const double factor : {0.01, 0.3, 0.9, 1.2, 4.0, 50.0}) {
      const double s = factor * scale * scale, h = 1e-5 * s;
      double rho[3], above[3], below[3];
      loss->Evaluate(s, rho);
      loss->Evaluate(s + h, above);
      loss->Evaluate(s - h, below);
      EXPECT_NEAR((above[0] - below[0]) / (2 * h), rho[1], 1e-7) << GetParam() << " at " << s;
      EXPECT_NEAR((above[1] - below[1]) / (2 * h), rho[2], 1e-6 * (1 + std::abs(rho[2])));
    }
  }
}

TEST_P(EveryLoss, IsQuadraticNearZeroAndWeakerFarAway) {
  const auto loss = MakeLoss({GetParam(), 2.0});
  EXPECT_NEAR(Rho(*loss, 1e-8) / 1e-8, 1.0, 1e-6);
  double rho[3];
  loss->Evaluate(1e4, rho);
  EXPECT_LT(rho[1], 0.1);
  EXPECT_GE(rho[1], 0.0);
}

TEST_P(EveryLoss, ParsesAndPrints) {
  EXPECT_EQ(ParseLoss(GetParam()).ToString(), GetParam());
  EXPECT_EQ(ParseLoss(GetParam() + ":2.5").scale, 2.5);
  EXPECT_EQ(ParseLoss(GetParam() + ":2.5").ToString(), GetParam() + ":2.5");
}

std::vector<std::string> RobustNames() {
  std::vector<std::string> names = LossNames();
  std::erase_if(names, [](const std::string& n) { return n == "none" || IsGraduated({n, 0.0}); });
  return names;
}
INSTANTIATE_TEST_SUITE_P(Losses, EveryLoss, testing::ValuesIn(RobustNames()),
                         [](const auto& test) { return test.param; });

TEST(GemanMcClure, SaturatesAtItsSquaredScale) {
  EXPECT_NEAR(Rho(GemanMcClureLoss(3.0), 1e12), 9.0, 1e-6);
}

TEST(Dcs, DerivativeIsTheSquaredWeightOfTheMethod) {
  // s_ij = 2 phi / (phi + chi^2), Agarwal et al. 2013.
  double rho[3];
  DcsLoss(2.0).Evaluate(12.0, rho);
  EXPECT_NEAR(rho[1], std::pow(2.0 * 4.0 / (4.0 + 12.0), 2), 1e-15);
}

TEST(GraduatedThreshold, IsTheQuantileOfChiSquare) {
  // 99 %, from tables.
  for (const auto& [dimension, quantile] :
       {std::pair(1, 6.635), {2, 9.210}, {3, 11.345}, {6, 16.812}, {15, 30.578}}) {
    EXPECT_NEAR(GraduatedThreshold({"gnc_tls", 0.0}, dimension) / quantile, 1.0, 1e-4);
    EXPECT_DOUBLE_EQ(GraduatedThreshold({"gnc_tls", 3.0}, dimension), 9.0);
  }
}

TEST(ParseLoss, TakesGraduatedLosses) {
  for (const char* name : {"gnc_tls", "gnc_gm"}) {
    EXPECT_TRUE(IsGraduated(ParseLoss(name)));
    EXPECT_EQ(ParseLoss(std::string(name) + ":3").scale, 3.0);
    EXPECT_EQ(MakeLoss(ParseLoss(name)), nullptr);
  }
  EXPECT_FALSE(IsGraduated(ParseLoss("geman_mcclure")));
}

TEST(ParseLoss, NoneHasNoFunction) { EXPECT_EQ(MakeLoss(ParseLoss("none")), nullptr); }

TEST(ParseLoss, RefusesWhatIsNotALoss) {
  for (const char* text : {"", "nothing", "huber:", "huber:0", "huber:-1", "huber:1x", "huber:nan",
                           "huber:inf", "none:1", "Huber"}) {
    EXPECT_THROW(ParseLoss(text), UsageError) << text;
  }
}

TEST(FactorLosses, AreReadAndPrinted) {
  const FactorLosses losses =
      ParseFactorLosses("cauchy:1,relative_pose=huber:2,robot_position=tukey:3,moments=gnc_tls", {},
                        BuiltinFactors());
  EXPECT_EQ(losses.general.ToString(), "cauchy:1");
  ASSERT_EQ(losses.by_type.size(), 3u);
  EXPECT_EQ(losses.by_type.at("relative_pose").ToString(), "huber:2");
  EXPECT_EQ(losses.by_type.at("robot_position").ToString(), "tukey:3");
  const std::string text = losses.ToString();
  EXPECT_EQ(ParseFactorLosses(text, {}, BuiltinFactors()).ToString(), text);
}

TEST(FactorLosses, WithoutTheFirstPartTheGeneralOneStays) {
  const FactorLosses losses = ParseFactorLosses("gravity=dcs", {"cauchy", 2.4}, BuiltinFactors());
  EXPECT_EQ(losses.ToString(), "cauchy:2.4,gravity=dcs");
}

TEST(FactorLosses, EveryFactorTakesOne) {
  for (const auto& [name, type] : BuiltinFactors().types()) {
    EXPECT_EQ(ParseFactorLosses(name + "=huber", {}, BuiltinFactors()).by_type.count(name), 1u);
  }
}

TEST(FactorLosses, WhatIsNotSoIsWrongUsage) {
  for (const char* text : {"", "huber,cauchy", "huber,", "huber,=dcs", "relative_pose=",
                           "relative_pose=nothing", "relative_pose=huber,relative_pose=dcs"}) {
    EXPECT_THROW(ParseFactorLosses(text, {}, BuiltinFactors()), UsageError) << text;
  }
  try {
    ParseFactorLosses("gps=tukey:3", {}, BuiltinFactors());
    ADD_FAILURE() << "there is no factor gps";
  } catch (const UsageError& error) {
    for (const auto& [name, type] : BuiltinFactors().types()) {
      EXPECT_NE(std::string(error.what()).find(name), std::string::npos) << name;
    }
  }
}

TEST(ParseLoss, TakesCeresNameOfSoftL1) {
  EXPECT_EQ(ParseLoss("soft_l_one:2").ToString(), "soft_l1:2");
}

}  // namespace
}  // namespace planegraph
