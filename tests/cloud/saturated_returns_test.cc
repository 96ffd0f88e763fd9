#include "planegraph/cloud/saturated_returns.h"

#include <gtest/gtest.h>

#include <cmath>

namespace planegraph {
namespace {

constexpr double kLargest = 30.0;  // metres

// A floor around the scanner, up to 20 m away.
Cloud Floor() {
  Cloud cloud;
  for (int i = 0; i < 5000; ++i) {
    const double angle = 2.399963 * i, radius = 1.0 + 19.0 * i / 5000;
    cloud.points.push_back(
        Eigen::Vector3d(radius * std::cos(angle), radius * std::sin(angle), -0.8).cast<float>());
    cloud.intensities.push_back(static_cast<float>(i));
  }
  return cloud;
}

void AddAt(Cloud* cloud, const Eigen::Vector3d& direction, double range) {
  cloud->points.push_back((range * direction.normalized()).cast<float>());
  cloud->intensities.push_back(-1.0f);
}

// Beams upwards that came back with the largest range there is.
void AddSky(Cloud* cloud, int count) {
  for (int i = 0; i < count; ++i) {
    AddAt(cloud, {std::cos(0.1 * i), std::sin(0.1 * i), 0.5 + 0.01 * (i % 50)}, kLargest);
  }
}

TEST(SaturatedReturns, ASpikeAtTheLargestRangeIsDropped) {
  Cloud cloud = Floor();
  AddSky(&cloud, 400);
  const Cloud kept = DropSaturatedReturns(cloud);
  EXPECT_EQ(kept.size(), 5000u);
  for (std::size_t i = 0; i < kept.size(); ++i)
    EXPECT_EQ(kept.intensities[i], static_cast<float>(i));
}

TEST(SaturatedReturns, ItsPlaceIsThatOfTheViewpointNotTheOrigin) {
  Cloud cloud = Floor();
  AddSky(&cloud, 400);
  const Eigen::Vector3f shift(4, -7, 2);
  for (auto& p : cloud.points) p += shift;
  cloud.offset = {500000, 5000000, 100};
  cloud.viewpoint = cloud.offset + shift.cast<double>();
  EXPECT_EQ(DropSaturatedReturns(cloud).size(), 5000u);
}

TEST(SaturatedReturns, AWallAtTheFarEndStays) {
  Cloud cloud = Floor();
  // A flat wall x = 30: ranges from 30 m to 31.2 m.
  for (int i = 0; i < 40; ++i) {
    for (int k = 0; k < 20; ++k) {
      const Eigen::Vector3d point(30.0, -8.0 + 0.4 * i, -1.0 + 0.2 * k);
      AddAt(&cloud, point, point.norm());
    }
  }
  EXPECT_EQ(DropSaturatedReturns(cloud).size(), cloud.size());
}

TEST(SaturatedReturns, AFewFarPointsAreNoSpike) {
  Cloud cloud = Floor();
  AddSky(&cloud, 8);
  EXPECT_EQ(DropSaturatedReturns(cloud).size(), cloud.size());
}

TEST(SaturatedReturns, ACloudWithoutPoints) { EXPECT_EQ(DropSaturatedReturns({}).size(), 0u); }

}  // namespace
}  // namespace planegraph
