#include "planegraph/evaluation/plane_thickness.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "planegraph/base/error.h"
#include "planegraph/evaluation/map_quality.h"

namespace planegraph {
namespace {

constexpr double kSigma = 0.004;

// A wall of 8 x 4 m in the plane x = offset.
void AddWall(double offset, std::uint8_t vision, std::int32_t scan, std::int32_t plane,
             LabelledCloud* map, int count = 20000) {
  std::mt19937 random(static_cast<unsigned>(100 * scan + plane + vision + 7));
  std::uniform_real_distribution<float> place(0.0f, 1.0f);
  std::normal_distribution<float> noise(0.0f, static_cast<float>(kSigma));
  for (int i = 0; i < count; ++i) {
    map->cloud.points.emplace_back(static_cast<float>(offset) + noise(random), 8.0f * place(random),
                                   4.0f * place(random));
    map->vision.push_back(vision);
    map->scans.push_back(scan);
    map->planes.push_back(plane);
  }
}

TEST(PlaneThickness, OfTwoScansApart) {
  for (double apart : {0.0, 0.01, 0.04}) {
    LabelledCloud map;
    AddWall(0.3, 0, 0, 5, &map);
    AddWall(0.3 + apart, 0, 1, 2, &map);
    const PlaneThickness thickness = ComputePlaneThickness(map);
    ASSERT_EQ(thickness.landmarks.size(), 1u) << apart;
    EXPECT_EQ(thickness.landmarks[0].scan, 0);
    EXPECT_EQ(thickness.landmarks[0].plane, 5);
    EXPECT_EQ(thickness.landmarks[0].scans, 2u);
    // Two equal halves `apart` from each other: half of it from their middle.
    EXPECT_NEAR(thickness.laser_on_laser.Rms(), std::hypot(kSigma, 0.5 * apart), 1e-4) << apart;
    EXPECT_NEAR(thickness.within_scans.Rms(), kSigma, 1e-4);
    EXPECT_TRUE(std::isnan(thickness.map_on_laser.Rms()));
  }
}

TEST(PlaneThickness, OfADroneMapOnTheLaser) {
  LabelledCloud map;
  AddWall(0.3, 0, 0, 0, &map);
  AddWall(0.35, 1, -1, 3, &map, 5000);
  const PlaneThickness thickness = ComputePlaneThickness(map);
  ASSERT_EQ(thickness.landmarks.size(), 1u);
  EXPECT_NEAR(thickness.landmarks[0].map_on_laser.Rms(), std::hypot(kSigma, 0.05), 2e-4);
  // One scan alone: its own noise, and nothing of registration.
  EXPECT_NEAR(thickness.landmarks[0].laser_on_laser.Rms(), kSigma, 1e-4);
  EXPECT_EQ(thickness.laser_on_laser.points, 0.0);
}

TEST(PlaneThickness, KeepsSurfacesApart) {
  LabelledCloud map;
  for (std::int32_t scan = 0; scan < 2; ++scan) {
    AddWall(0.2, 0, scan, 0, &map);
    AddWall(0.5, 0, scan, 1, &map);
  }
  AddWall(5.0, 0, 2, -1, &map);  // part of no plane
  const PlaneThickness thickness = ComputePlaneThickness(map);
  EXPECT_EQ(thickness.landmarks.size(), 2u);
  EXPECT_NEAR(thickness.laser_on_laser.Rms(), kSigma, 1e-4);
  EXPECT_TRUE(ComputePlaneThickness(LabelledCloud()).landmarks.empty());
}

// ---- the same points under two estimates ----

Cloud TwoScans(double apart) {
  LabelledCloud map;
  AddWall(0.3, 0, 0, 0, &map);
  AddWall(0.3 + apart, 0, 1, 0, &map);
  return map.cloud;
}

MapQualityOptions Kept() {
  MapQualityOptions options;
  options.radius = 0.15;
  options.keep_values = true;
  return options;
}

TEST(CompareQuality, IsTheDifferenceOverCommonPoints) {
  const Cloud sharp = TwoScans(0.0), blurred = TwoScans(0.02);
  const MapQuality a = ComputeMapQuality(sharp, Kept()), b = ComputeMapQuality(blurred, Kept());
  const MapQualityDifference difference = CompareQuality(sharp, a, b, Kept(), 0.95);
  EXPECT_EQ(difference.points, a.used);
  EXPECT_EQ(a.used, b.used);
  EXPECT_NEAR(difference.mme, b.mme - a.mme, 1e-6);
  EXPECT_NEAR(difference.mpv, b.mpv - a.mpv, 1e-8);
  EXPECT_NEAR(difference.thickness_mean, b.thickness_mean - a.thickness_mean, 1e-8);
  ASSERT_TRUE(difference.intervals.mme);
  EXPECT_GT(difference.intervals.mme->low, 0.0);  // clearly blurred
  EXPECT_LT(difference.intervals.mme->low, difference.mme);
  EXPECT_GT(difference.intervals.mme->high, difference.mme);
}

TEST(CompareQuality, RefusesUnequalSets) {
  const Cloud cloud = TwoScans(0.0);
  const MapQuality a = ComputeMapQuality(cloud, Kept());
  MapQuality b = a;
  b.values.pop_back();
  EXPECT_THROW(CompareQuality(cloud, a, b, Kept(), 0.95), UsageError);
  b.values.clear();
  EXPECT_THROW(CompareQuality(cloud, b, b, Kept(), 0.95), UsageError);
}

TEST(QualityIntervals, HoldTheMean) {
  const Cloud cloud = TwoScans(0.0);
  const MapQuality quality = ComputeMapQuality(cloud, Kept());
  const auto intervals = ComputeIntervals(cloud, quality, Kept(), 0.95);
  EXPECT_GE(intervals.blocks, 18u);
  ASSERT_TRUE(intervals.mme && intervals.mpv && intervals.thickness_mean);
  EXPECT_LT(intervals.mme->low, quality.mme);
  EXPECT_GT(intervals.mme->high, quality.mme);
  EXPECT_LT(intervals.mme->high - intervals.mme->low, 0.5);
}

}  // namespace
}  // namespace planegraph
