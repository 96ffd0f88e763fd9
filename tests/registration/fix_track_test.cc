#include "registration/fix_track.h"

#include <gtest/gtest.h>

namespace planegraph {
namespace {

// Metric fixes at the given times, at x = 2 time.
GpsTrack TrackAt(const std::vector<double>& times) {
  GpsTrack track;
  track.metric = true;
  for (double time : times) {
    GpsFix fix;
    fix.time = time;
    fix.metric = {2.0 * time, 0.0, 0.0};
    track.fixes.push_back(fix);
  }
  return track;
}

TEST(FixTrack, InterpolatesBetweenFixesInAnyOrder) {
  const FixTrack track(TrackAt({3.0, 1.0, 2.0, 2.0}), {});
  ASSERT_EQ(track.fixes().size(), 3u);  // one for each time
  const auto moving = track.Interpolate(1.25, 5.0);
  ASSERT_TRUE(moving.has_value());
  EXPECT_NEAR(moving->position.x(), 2.5, 1e-12);
  EXPECT_NEAR(moving->velocity.x(), 2.0, 1e-12);
}

TEST(FixTrack, NotOverGapsNorBeyondTheEnds) {
  const FixTrack track(TrackAt({0.0, 1.0, 20.0}), {});
  EXPECT_FALSE(track.Interpolate(10.0, 5.0));
  EXPECT_FALSE(track.Interpolate(-0.5, 5.0));
  EXPECT_FALSE(track.Interpolate(20.5, 5.0));
  EXPECT_TRUE(track.Interpolate(20.0, 5.0));  // at a fix, though the gap before it is wide
  EXPECT_EQ(track.Nearest(11.0)->time, 20.0);
  EXPECT_EQ(FixTrack().Nearest(0.0), nullptr);
}

TEST(FixTrack, ClocksMayBeWholeDaysApart) {
  const double midnight = 86400.0 * 20000;
  const FixTrack of_the_day(TrackAt({36000.0, 36010.0}), {});
  EXPECT_EQ(of_the_day.DayShift(midnight + 36002.0, midnight + 36008.0), -midnight);
  EXPECT_EQ(of_the_day.DayShift(36002.0, 36008.0), 0.0);
  EXPECT_EQ(of_the_day.DayShift(midnight + 50000.0, midnight + 50001.0), 0.0);  // another hour
  EXPECT_EQ(FixTrack().DayShift(0.0, 1.0), 0.0);
}

}  // namespace
}  // namespace planegraph
