#include "planegraph/simulation/flight.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "planegraph/base/error.h"

namespace planegraph {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

FlightOptions AsPlanned() {
  FlightOptions options;
  options.position_sigma = options.tilt_sigma = options.line_pitch = 0.0;
  return options;
}

Flight Plan(const FlightOptions& options, const Vector2d& low = {-20.0, -25.0},
            const Vector2d& high = {20.0, 25.0}, std::uint64_t seed = 1) {
  Random random(seed);
  return PlanFlight(low, high, options, &random);
}

TEST(PinholeCameraTest, ProjectionAndDirectionAreInverse) {
  const PinholeCamera camera;
  EXPECT_NEAR(camera.FocalPixels(), 460.0, 1e-12);
  EXPECT_EQ(camera.Direction({320.0, 240.0}), Vector3d(0.0, 0.0, 1.0));
  for (const Vector2d& pixel : {Vector2d(10.0, 20.0), Vector2d(600.0, 333.0)}) {
    const auto again = camera.Project(7.0 * camera.Direction(pixel));
    ASSERT_TRUE(again.has_value());
    EXPECT_LT((*again - pixel).norm(), 1e-10);
  }
}

TEST(PinholeCameraTest, NothingBehindOrBesideTheImage) {
  const PinholeCamera camera;
  EXPECT_FALSE(camera.Project({0.0, 0.0, -5.0}));
  EXPECT_FALSE(camera.Project({0.0, 0.0, 0.0}));
  EXPECT_FALSE(camera.Project({5.0 * 0.7, 0.0, 5.0}));
  EXPECT_TRUE(camera.Project({5.0 * 0.69, 0.0, 5.0}));
}

TEST(FlightTest, LinesLookDownWithTheirHeadingUpwardsInTheImage) {
  FlightOptions options = AsPlanned();
  options.ring_images = options.inner_ring_images = 0;
  const Flight flight = Plan(options);
  ASSERT_GT(flight.world_from_camera.size(), 2u);
  const Rigid3& first = flight.world_from_camera[0];
  EXPECT_LT((first.rotation * Vector3d::UnitZ() + Vector3d::UnitZ()).norm(), 1e-12);
  // The first line goes north: east is to the right of the image, and its lower edge is south.
  EXPECT_LT((first.rotation * Vector3d::UnitX() - Vector3d::UnitX()).norm(), 1e-12);
  EXPECT_LT((first.rotation * Vector3d::UnitY() + Vector3d::UnitY()).norm(), 1e-12);
}

TEST(FlightTest, FootprintsOverlapAsAsked) {
  FlightOptions options = AsPlanned();
  options.ring_images = options.inner_ring_images = 0;
  const Flight flight = Plan(options);
  const double width = options.height / 0.71875, height = width * 0.75;
  double largest_along = 0.0, largest_across = 0.0;
  for (std::size_t k = 1; k < flight.world_from_camera.size(); ++k) {
    const Vector3d step =
        flight.world_from_camera[k].translation - flight.world_from_camera[k - 1].translation;
    largest_across = std::max(largest_across, std::abs(step.x()));
    largest_along = std::max(largest_along, std::abs(step.y()));
    EXPECT_NEAR(step.z(), 0.0, 1e-12);
  }
  EXPECT_LE(largest_along, height * (1.0 - options.overlap_along) + 1e-9);
  EXPECT_GT(largest_along, 0.7 * height * (1.0 - options.overlap_along));
  EXPECT_LE(largest_across, width * (1.0 - options.overlap_across) + 1e-9);
  EXPECT_GT(largest_across, 0.5 * width * (1.0 - options.overlap_across));
}

TEST(FlightTest, TheRingsLookAtTheMiddle) {
  const FlightOptions options = AsPlanned();
  const Flight flight = Plan(options);
  const std::size_t inner = flight.world_from_camera.size() - options.inner_ring_images;
  for (std::size_t k = inner - options.ring_images; k < flight.world_from_camera.size(); ++k) {
    const Rigid3& pose = flight.world_from_camera[k];
    const auto pixel = options.camera.Project(pose.Inverse() * Vector3d(0, 0, 2.0));
    ASSERT_TRUE(pixel.has_value());
    EXPECT_LT((*pixel - Vector2d(320.0, 240.0)).norm(), 1e-6);
    EXPECT_LT((pose.rotation * Vector3d::UnitY()).z(), -0.5) << "down is down";
    EXPECT_NEAR((pose.rotation * Vector3d::UnitX()).z(), 0.0, 1e-12) << "a level horizon";
    const double radius = pose.translation.head<2>().norm();
    EXPECT_TRUE(k < inner ? radius > 20.0 + 11.9 : radius > 9.9 && radius < 12.6) << radius;
  }
}

TEST(FlightTest, MovesWithItsArea) {
  const Vector2d shift(100.0, -40.0);
  const Flight here = Plan(FlightOptions());
  const Flight there =
      Plan(FlightOptions(), Vector2d(-20.0, -25.0) + shift, Vector2d(20.0, 25.0) + shift);
  ASSERT_EQ(here.world_from_camera.size(), there.world_from_camera.size());
  for (std::size_t k = 0; k < here.world_from_camera.size(); ++k) {
    const Rigid3 &a = here.world_from_camera[k], &b = there.world_from_camera[k];
    EXPECT_LT((b.translation - a.translation - Vector3d(100.0, -40.0, 0.0)).norm(), 1e-9);
    EXPECT_LT(a.rotation.angularDistance(b.rotation), 1e-7);
  }
}

TEST(FlightTest, TimesFollowTheSpeed) {
  FlightOptions options;
  options.speed = 4.0;
  const Flight flight = Plan(options);
  ASSERT_EQ(flight.times.size(), flight.world_from_camera.size());
  EXPECT_EQ(flight.times[0], options.start_time);
  for (std::size_t k = 1; k < flight.times.size(); ++k) {
    const double way =
        (flight.world_from_camera[k].translation - flight.world_from_camera[k - 1].translation)
            .norm();
    EXPECT_NEAR(flight.times[k] - flight.times[k - 1], std::max(way / 4.0, 0.1), 1e-9);
  }
}

TEST(FlightTest, RefusesOptionsWithoutSense) {
  const auto refused = [](const auto& change) {
    FlightOptions options;
    change(&options);
    EXPECT_THROW(Plan(options), UsageError);
  };
  const double nan = std::numeric_limits<double>::quiet_NaN();
  refused([](FlightOptions* o) { o->overlap_along = 1.0; });
  refused([&](FlightOptions* o) { o->overlap_across = nan; });
  refused([](FlightOptions* o) { o->overlap_along = o->overlap_across = 0.9999; });
  refused([](FlightOptions* o) { o->height = 0.0; });
  refused([&](FlightOptions* o) { o->height = nan; });
  refused([](FlightOptions* o) { o->speed = -1.0; });
  refused([](FlightOptions* o) { o->ring_images = -1; });
  refused([](FlightOptions* o) { o->inner_ring_images = 1000000; });
  refused([](FlightOptions* o) { o->camera.focal = 0.0; });
  refused([](FlightOptions* o) { o->camera.width = 0; });
  EXPECT_THROW(Plan(FlightOptions(), {0.0, 0.0}, {1e9, 1e9}), UsageError);
  EXPECT_THROW(Plan(FlightOptions(), {0.0, 0.0}, {nan, 1.0}), UsageError);
}

}  // namespace
}  // namespace planegraph
