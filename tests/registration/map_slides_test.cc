// Poses beside the one that was found, and what a start says of a pose.
#include "registration/map_slides.h"

#include <gtest/gtest.h>

#include <cmath>

#include "registration/start_prior.h"
#include "registration/village_map.h"

namespace planegraph {
namespace {

constexpr double kSlideGate = 0.1;

MapRefinement RefinedAt(const VillageMap& map, const MadeScan& scan, const Sim3& pose) {
  MapRefinementOptions options;
  options.first_gate = 0.3;
  return RefineInMap(map.model(), ScanGroup(scan.model()), pose, options);
}

TEST(ClosestSlide, AmongHousesThePoseLeadsOnEverySide) {
  const VillageMap map;
  const Rigid3 pose = MakePose(0, 0, 1.3, 0.4);
  const MadeScan scan(Village(), pose, 1);
  const MapRefinement found = RefinedAt(map, scan, Sim3(pose));
  const Slide slide = ClosestSlide(map.model(), ScanGroup(scan.model()), found, kSlideGate);
  EXPECT_GT(slide.lead, std::log(1e3));
  EXPECT_GE(slide.metres, 2.0 * MapRefinementOptions().last_gate);
  EXPECT_NEAR((slide.map_from_group.translation - found.map_from_group.translation).norm(),
              slide.metres, 1e-9);
}

TEST(ClosestSlide, OnBareGroundAPoseBesideFitsAsWell) {
  RayWorld ground;
  ground.AddFace({0, 0, 0}, Eigen::Vector3d::UnitZ(), 25.0, 25.0);
  const VillageMap map(ground);
  const Rigid3 pose = MakePose(0, 0, 1.3, 0.4);
  const MadeScan scan(ground, pose, 1);
  const MapRefinement found = RefinedAt(map, scan, Sim3(pose));
  const Slide slide = ClosestSlide(map.model(), ScanGroup(scan.model()), found, kSlideGate);
  EXPECT_LT(std::abs(slide.lead), 1.0);
}

// A straight street along x that ends at `ends` of its ends: houses on both sides hold it across.
RayWorld StraightStreet(int ends) {
  RayWorld world;
  world.AddFace({0, 0, 0}, Eigen::Vector3d::UnitZ(), 14.0, 45.0);
  for (const double side : {-1.0, 1.0}) {
    world.AddFace({0, side * 7.0, 3.0}, {0, -side, 0}, 40.0, 3.0);
    if (side < 2.0 * ends - 2.0) {
      world.AddFace({side * 12.0, 0, 3.0}, {-side, 0, 0}, 6.0, 3.0);
    }
  }
  return world;
}

Slide SlideInStreet(int ends) {
  const RayWorld world = StraightStreet(ends);
  const VillageMap map(world);
  const Rigid3 pose = MakePose(0, 0, 1.3, 0.1);
  const MadeScan scan(world, pose, 1, 60000);
  return ClosestSlide(map.model(), ScanGroup(scan.model()), RefinedAt(map, scan, Sim3(pose)),
                      kSlideGate);
}

// However long the wall is and however well it fits: it is one.
TEST(ClosestSlide, OneWallAcrossAStreetDoesNotHoldItAlong) {
  const Slide slide = SlideInStreet(1);
  EXPECT_GT(std::abs(slide.direction.x()), 0.95);
  EXPECT_LT(slide.lead, std::log(1e3));
  EXPECT_GT(slide.lead_of_all, slide.lead);
}

TEST(ClosestSlide, WallsAtBothEndsOfAStreetHoldItAlong) {
  EXPECT_GT(SlideInStreet(2).lead, std::log(1e3));
}

TEST(ClosestSlide, TheLeadIsNeverMoreThanThatOfAllSurfaces) {
  for (const int ends : {0, 1, 2}) {
    const Slide slide = SlideInStreet(ends);
    EXPECT_LE(slide.lead, slide.lead_of_all + 1e-9) << ends;
    EXPECT_NEAR(slide.direction.norm(), 1.0, 1e-9);
  }
}

MapPrior StartAt(double sigma_translation, double sigma_rotation) {
  MapPrior prior;
  prior.upright = true;
  prior.pose = MapPrior::Pose{Rigid3(), sigma_translation, sigma_rotation};
  return prior;
}

const Eigen::Vector3d kExtent(100, 100, 20);

TEST(LogStartRatio, IsZeroWithoutAStart) {
  EXPECT_EQ(LogStartRatio(kExtent, {}, Sim3(1.0, ExpSO3({0, 0, 1}), {1, 2, 3})), 0.0);
}

// A density over an even one has mean 1 over the window, whatever the sigmas.
TEST(LogStartRatio, ItsMeanOverTheWindowIsOne) {
  const double metres = 0.7, radians = 0.1;
  const MapPrior prior = StartAt(metres, radians);
  const double reach = 3.0 * metres, around = std::sqrt(3.0) * 3.0 * radians;
  constexpr int kSteps = 24;
  double sum = 0.0;
  for (int i = 0; i < kSteps; ++i) {
    for (int j = 0; j < kSteps; ++j) {
      for (int k = 0; k < kSteps; ++k) {
        const Eigen::Vector3d at = 2.0 * (Eigen::Vector3d(i, j, k).array() + 0.5) / kSteps - 1.0;
        const Sim3 pose(1.0, ExpSO3({0, 0, around * at.z()}), {reach * at.x(), reach * at.y(), 0});
        sum += std::exp(LogStartRatio(kExtent, prior, pose));
      }
    }
  }
  EXPECT_NEAR(sum / std::pow(kSteps, 3), 1.0, 0.01);
}

TEST(LogStartRatio, FallsWithTheDistanceAndNotBelowAWrongStart) {
  const MapPrior prior = StartAt(1.0, 0.17);
  const auto at = [&](double x) {
    return LogStartRatio(kExtent, prior, Sim3(1.0, Eigen::Quaterniond::Identity(), {x, 0, 0}));
  };
  EXPECT_GT(at(0.0), at(1.0));
  EXPECT_GT(at(1.0), at(2.0));
  EXPECT_NEAR(at(30.0), std::log(0.1), 1e-6);
}

// Who knows nothing says nothing.
TEST(LogStartRatio, AStartThatMayBeAnywhereHardlyCounts) {
  const MapPrior prior = StartAt(1e3, std::numbers::pi);
  for (const double x : {-40.0, 0.0, 40.0}) {
    for (const double heading : {-3.0, 0.0, 3.0}) {
      const Sim3 pose(1.0, ExpSO3({0, 0, heading}), {x, -x, 2.0});
      EXPECT_NEAR(LogStartRatio(kExtent, prior, pose), 0.0, 0.4);
    }
  }
}

}  // namespace
}  // namespace planegraph
