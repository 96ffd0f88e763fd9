#include "planegraph/pipeline/robot_positions.h"

#include <gtest/gtest.h>

#include <fstream>

#include "io/test_files.h"

namespace planegraph {
namespace {

class RobotPositions : public TestFolder {
 protected:
  // A robot that scanned at these times, with a receiver whose file says x = 2 t for t = 100 ...
  // 110.
  Site SiteAt(const std::vector<double>& times) {
    std::ofstream file(Path("gps.csv"));
    file << "time,x,y,z\n";
    for (int t = 100; t <= 110; ++t) file << t << "," << 2 * t << ",0,0\n";
    file.close();
    Site site;
    RobotSite& robot = site.robots.emplace_back();
    robot.name = "cart";
    robot.odometry.emplace();
    robot.odometry->has_times = true;
    robot.odometry->times = times;
    robot.odometry->poses.resize(times.size());
    robot.gps.emplace();
    robot.gps->file = Path("gps.csv");
    return site;
  }

  static std::vector<ScanRecord> Scans(std::size_t count) {
    std::vector<ScanRecord> scans(count);
    for (std::size_t i = 0; i < count; ++i) scans[i].index = i;
    return scans;
  }

  static std::vector<MapRecord> PlacedMap() {
    std::vector<MapRecord> maps(1);
    maps[0].georeference.emplace();
    maps[0].georeference->status = "ok";
    return maps;
  }

  std::vector<std::string> warnings_;
};

TEST_F(RobotPositions, BetweenTheFixesOfTheScansTimes) {
  const auto found =
      ReadRobotPositions(SiteAt({99.5, 103.25, 200.0}), Scans(3), PlacedMap(), &warnings_);
  ASSERT_EQ(found.size(), 2u);
  EXPECT_EQ(found[0].scan, 0u);
  EXPECT_NEAR(found[0].position.x(), 200.0, 1e-9);  // the first fix, half a second later
  EXPECT_EQ(found[1].scan, 1u);
  EXPECT_NEAR(found[1].position.x(), 206.5, 1e-9);
}

// A receiver that gives the time of the day alone, and odometry in seconds since 1970.
TEST_F(RobotPositions, ClocksMayBeWholeDaysApart) {
  const double midnight = 86400.0 * 20000;
  const auto found = ReadRobotPositions(SiteAt({midnight + 102.5, midnight + 108.0}), Scans(2),
                                        PlacedMap(), &warnings_);
  ASSERT_EQ(found.size(), 2u);
  EXPECT_NEAR(found[0].position.x(), 205.0, 1e-6);
  EXPECT_NEAR(found[1].position.x(), 216.0, 1e-6);
}

TEST_F(RobotPositions, WithoutAPlacedMapTheyAreLeftOutWithAWarning) {
  EXPECT_TRUE(ReadRobotPositions(SiteAt({103.0}), Scans(1), {}, &warnings_).empty());
  ASSERT_EQ(warnings_.size(), 1u);
}

}  // namespace
}  // namespace planegraph
