// Simulated sites with a drone, as the site reader sees them.
#include <gtest/gtest.h>

#include <cmath>

#include "io/test_files.h"
#include "planegraph/pipeline/site.h"
#include "planegraph/simulation/odometry.h"
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

// Squared errors of steps straight ahead by the variance that the site file makes of them: of one
// step, and of the way of twenty, whose common error grows with it.
TEST_F(SimulatedQuarter, StatesWhatItsOdometryErrsBy) {
  constexpr int kRuns = 400, kSteps = 20;
  const OdometryNoise noise = ReadSite(Path("site/site.yaml")).robots[0].odometry_noise;
  std::vector<Rigid3> truth(kSteps + 1);
  for (int k = 0; k <= kSteps; ++k) truth[k].translation.x() = 3.0 * k;
  OdometryOptions straight;  // no turn, which would show as length on the way
  straight.yaw_drift_min = straight.yaw_drift_max = straight.yaw_sigma = straight.tilt_sigma = 0.0;
  const double own = std::pow(noise.step + 3.0 * noise.per_metre, 2);
  const auto variance = [&](int n) { return n * own + std::pow(3.0 * n * noise.scale, 2); };
  double one = 0.0, all = 0.0;
  for (int run = 0; run < kRuns; ++run) {
    Random random(static_cast<std::uint64_t>(run), 0);
    const auto odometry = SimulateOdometry(truth, straight, &random);
    one += std::pow(odometry[1].translation.x() - 3.0, 2) / variance(1) / kRuns;
    all += std::pow(odometry[kSteps].translation.x() - 3.0 * kSteps, 2) / variance(kSteps) / kRuns;
  }
  // Four standard deviations of the mean of so many squares of normal numbers.
  const double band = 4.0 * std::sqrt(2.0 / kRuns);
  EXPECT_NEAR(one, 1.0, band);
  EXPECT_NEAR(all, 1.0, band);
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
