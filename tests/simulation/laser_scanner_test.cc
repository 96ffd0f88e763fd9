#include "planegraph/simulation/laser_scanner.h"

#include <gtest/gtest.h>

#include <cmath>

#include "planegraph/base/error.h"
#include "planegraph/simulation/mesh_parts.h"

namespace planegraph {
namespace {

using Eigen::Vector3d;

// A wall that fills the view ahead.
LabelledMesh WallAhead(double distance = 10.0) {
  MeshBuilder builder;
  AddBox(&builder, Rigid3(), {distance, -100.0, -100.0}, {distance + 0.5, 100.0, 100.0});
  return builder.mesh();
}

TEST(RayCasterTest, FindsTheNearestFaceWithItsIncidence) {
  MeshBuilder builder;
  AddBox(&builder, Rigid3(), {10.0, -5.0, -5.0}, {11.0, 5.0, 5.0});
  AddSphere(&builder, {-4.0, 0.0, 0.0}, 1.0);
  const RayCaster caster(builder.mesh());
  const auto hit = caster.Cast({0.0, 0.0, 0.0}, Vector3d(0.8, 0.0, 0.6).normalized(), 20.0);
  EXPECT_FALSE(hit.has_value()) << "passes above the box";
  const Vector3d inclined = Vector3d(1.0, 0.0, 0.25).normalized();
  const auto on_box = caster.Cast({0.0, 0.0, 0.0}, inclined, 20.0);
  ASSERT_TRUE(on_box.has_value());
  EXPECT_NEAR(on_box->distance, 10.0 / inclined.x(), 1e-12);
  EXPECT_NEAR(on_box->cosine, inclined.x(), 1e-12);
  EXPECT_NEAR(builder.mesh().planes[on_box->label].normal.x(), -1.0, 1e-12);
  const auto on_sphere = caster.Cast({0.0, 0.0, 0.0}, -Vector3d::UnitX(), 20.0);
  ASSERT_TRUE(on_sphere.has_value());
  EXPECT_EQ(on_sphere->label, kNotPlanar);
  EXPECT_NEAR(on_sphere->distance, 3.0, 0.01);
  EXPECT_FALSE(caster.Cast({0.0, 0.0, 0.0}, Vector3d::UnitX(), 9.9).has_value());
}

TEST(LaserScannerTest, BeamsLieInTheTurningFan) {
  const RayCaster caster(WallAhead());
  ScannerOptions options = ScannerOptions().WithoutNoise();
  options.beams = 5;
  options.sweeps = 2;
  options.fan = 1.0;
  Random random(1);
  const LabelledScan scan = Scan(caster, Rigid3(), options, &random);
  ASSERT_EQ(scan.cloud.size(), 10u);
  for (int i = 0; i < 10; ++i) {
    const double a = -0.5 + 0.25 * (i % 5), lateral = 10.0 * std::tan(a);
    const Vector3d expected = i < 5 ? Vector3d(10.0, lateral, 0.0) : Vector3d(10.0, 0.0, lateral);
    EXPECT_LT((scan.cloud.points[i].cast<double>() - expected).norm(), 1e-5) << i;
  }
}

TEST(LaserScannerTest, RangeNoiseFollowsTheModel) {
  const RayCaster caster(WallAhead(5.0));
  ScannerOptions options;
  options.mixed_share = 0.0;
  Random random(2);
  const LabelledScan scan = Scan(caster, Rigid3(), options, &random);
  // Near, far and grazing apart: x = 5 is seen at the incidence cosine 5 / r.
  double squares[3] = {}, sums[3] = {}, counts[3] = {};
  for (const auto& point : scan.cloud.points) {
    const Vector3d p = point.cast<double>();
    const double range = 5.0 * p.norm() / p.x(), cosine = 5.0 / range;
    if (range > 34.8) continue;  // the maximum range cuts the noise off
    const double sigma = 0.01 + 0.01 * range / 35.0 + (cosine < 0.3 ? 0.01 : 0.0);
    const double residual = (p.norm() - range) / sigma;
    const int bin = cosine < 0.3 ? 2 : (range > 8.0 ? 1 : 0);
    squares[bin] += residual * residual;
    sums[bin] += residual;
    counts[bin] += 1.0;
  }
  for (int bin = 0; bin < 3; ++bin) {
    ASSERT_GT(counts[bin], 500.0);
    EXPECT_NEAR(sums[bin] / counts[bin], 0.0, 4.5 / std::sqrt(counts[bin])) << bin;
    EXPECT_NEAR(squares[bin] / counts[bin], 1.0, 4.5 * std::sqrt(2.0 / counts[bin])) << bin;
  }
}

TEST(LaserScannerTest, DropOutsFollowTheModel) {
  const RayCaster caster(WallAhead());
  ScannerOptions options = ScannerOptions().WithoutNoise();
  Random random(3);
  const LabelledScan all = Scan(caster, Rigid3(), options, &random);
  options.dropout_constant = 0.1;
  options.dropout_quadratic = 0.4;
  const LabelledScan rest = Scan(caster, Rigid3(), options, &random);
  double expected = 0.0, variance = 0.0;
  for (const auto& point : all.cloud.points) {
    const double lost = 0.1 + 0.4 * point.squaredNorm() / (35.0 * 35.0);
    expected += 1.0 - lost;
    variance += lost * (1.0 - lost);
  }
  EXPECT_NEAR(static_cast<double>(rest.cloud.size()), expected, 4.5 * std::sqrt(variance));
}

TEST(LaserScannerTest, MixedPixelsLieBetweenTwoSurfacesAndHaveNoLabel) {
  MeshBuilder builder;
  AddBox(&builder, Rigid3(), {10.0, -100.0, -100.0}, {10.5, 100.0, 100.0});
  AddBox(&builder, Rigid3(), {8.0, -1.0, -1.0}, {8.1, 1.0, 1.0});
  const RayCaster caster(builder.mesh());
  ScannerOptions options = ScannerOptions().WithoutNoise();
  Random random(4);
  for (const int label : Scan(caster, Rigid3(), options, &random).labels) {
    EXPECT_NE(label, kNotPlanar);
  }
  options.mixed_share = 1.0;
  options.divergence = 0.01;
  const LabelledScan scan = Scan(caster, Rigid3(), options, &random);
  int mixed = 0;
  for (std::size_t i = 0; i < scan.labels.size(); ++i) {
    if (scan.labels[i] != kNotPlanar) continue;
    ++mixed;
    EXPECT_GT(scan.cloud.points[i].x(), 7.9f);
    EXPECT_LT(scan.cloud.points[i].x(), 10.1f);
  }
  EXPECT_GT(mixed, 50) << "the board has edges that many beams touch";
}

TEST(LaserScannerTest, RefusesOptionsWithoutSense) {
  const RayCaster caster(WallAhead());
  Random random(5);
  ScannerOptions none, inverted;
  none.beams = 0;
  inverted.min_range = 40.0;
  EXPECT_THROW(Scan(caster, Rigid3(), none, &random), UsageError);
  EXPECT_THROW(Scan(caster, Rigid3(), inverted, &random), UsageError);
}

}  // namespace
}  // namespace planegraph
