// Simulated sites with a drone, as the site reader sees them.
#include <gtest/gtest.h>

#include "io/test_files.h"
#include "planegraph/pipeline/site.h"
#include "planegraph/simulation/simulation.h"

namespace planegraph {
namespace {

class SimulatedQuarter : public TestFolder {
 protected:
  static SimulatedSite Quarter() {
    SimulationOptions options;
    options.scene = SceneKind::kQuarter;
    options.scans = 2;
    options.scanner.beams = options.scanner.sweeps = 31;
    options.drone.photogrammetry.pixel_step = 60;
    return Simulate(options);
  }
  SimulatedQuarter() { WriteSite(Path("site"), simulated_); }

  SimulatedSite simulated_ = Quarter();
};

TEST_F(SimulatedQuarter, HasTwoRobotsWithStartsAndAMap) {
  const Site site = ReadSite(Path("site/site.yaml"));
  ASSERT_EQ(site.robots.size(), 2u);
  for (std::size_t k = 0; k < 2; ++k) {
    const RobotSite& robot = site.robots[k];
    EXPECT_EQ(robot.name, simulated_.robots[k].name);
    EXPECT_EQ(robot.scans.size(), 2u);
    ASSERT_TRUE(robot.odometry.has_value());
    EXPECT_EQ(robot.odometry->times, simulated_.robots[k].times);
    ASSERT_TRUE(robot.start.has_value());
    const Eigen::Vector3d shift =
        robot.start->world_from_scan.translation - simulated_.robots[k].truth.front().translation;
    EXPECT_LT(shift.cwiseAbs().maxCoeff(), robot.start->sigma_translation);
    EXPECT_LT(robot.start->world_from_scan.rotation.angularDistance(
                  simulated_.robots[k].truth.front().rotation),
              0.17 + 0.14)
        << "10 degrees of heading, and the tilt of the ground";
  }
  ASSERT_EQ(site.maps.size(), 1u);
  EXPECT_EQ(site.maps[0].name, "uav1");
  for (const std::string& file :
       {site.maps[0].cloud, site.maps[0].cameras, site.maps[0].gps, site.maps[0].image_times}) {
    EXPECT_TRUE(std::filesystem::is_regular_file(file)) << file;
  }
}

TEST_F(SimulatedQuarter, TheOtherSiteFilesLeaveThingsOut) {
  const Site no_start = ReadSite(Path("site/site_nostart.yaml"));
  EXPECT_FALSE(no_start.robots[0].start || no_start.robots[1].start);
  EXPECT_EQ(no_start.maps.size(), 1u);
  const Site laser_only = ReadSite(Path("site/site_laser_only.yaml"));
  EXPECT_FALSE(laser_only.robots[0].start || laser_only.robots[1].start);
  EXPECT_EQ(laser_only.robots.size(), 2u);
  EXPECT_TRUE(laser_only.maps.empty());
}

}  // namespace
}  // namespace planegraph
