// Robots that know no map and no common start are joined by their scans.
#include "planegraph/pipeline/joining.h"

#include <gtest/gtest.h>

#include <filesystem>

#include "io/test_files.h"
#include "pipeline/small_site.h"
#include "planegraph/evaluation/trajectory_error.h"
#include "planegraph/io/trajectory_io.h"
#include "planegraph/pipeline/mapper.h"
#include "planegraph/simulation/simulation.h"

namespace planegraph {
namespace {

SimulatedSite Hall(std::uint64_t seed, int scans) {
  SimulationOptions options;
  options.scene = SceneKind::kHall;
  options.seed = seed;
  options.scans = scans;
  options.scanner.beams = 361;
  options.scanner.sweeps = 120;
  return Simulate(options);
}

// Some scans of a robot as a robot of their own: its odometry begins at the identity.
SimulatedRobot Part(const SimulatedRobot& robot, const std::string& name, std::size_t first,
                    std::size_t last) {
  SimulatedRobot part;
  part.name = name;
  for (std::size_t k = first; k < last; ++k) {
    part.scans.push_back(robot.scans[k]);
    part.times.push_back(robot.times[k]);
    part.truth.push_back(robot.truth[k]);
    part.odometry.push_back(robot.odometry[first].Inverse() * robot.odometry[k]);
  }
  return part;
}

class JoinRobots : public TestFolder {};

TEST_F(JoinRobots, ByTheSurfacesThatTheyHaveInCommon) {
  const SimulatedSite hall = Hall(3, 12);
  SimulatedSite two = hall;
  two.robots = {Part(hall.robots[0], "a", 0, 6), Part(hall.robots[0], "b", 6, 12)};
  WriteSite(Path("site"), two);
  const MapResult result = MapScans(ReadSite(Path("site/site.yaml")), TwoThreads());
  EXPECT_EQ(result.components, 1);
  std::size_t across = 0;
  for (const auto& pair : result.pairs) {
    across += pair.used && result.scans[pair.target].robot != result.scans[pair.source].robot;
  }
  EXPECT_GE(across, 2u);
  // One frame for both: positions relative to the first scan.
  const Rigid3 truth_from_world = hall.robots[0].truth[0];
  for (std::size_t i = 0; i < result.scans.size(); ++i) {
    const Eigen::Vector3d found = truth_from_world * result.solution.world_from_scan[i].translation;
    EXPECT_LT((found - hall.robots[0].truth[i].translation).norm(), 0.02) << i;
  }
}

TEST_F(JoinRobots, ButNotByPlacesThatAreNoneOfTheOthers) {
  SimulatedSite two = Hall(3, 12);
  const SimulatedSite other = Hall(11, 12);
  two.robots = {Part(two.robots[0], "a", 0, 4), Part(other.robots[0], "b", 0, 4)};
  WriteSite(Path("site"), two);
  const MapResult result = MapScans(ReadSite(Path("site/site.yaml")), TwoThreads());
  EXPECT_EQ(result.components, 2);
  for (const auto& pair : result.pairs) {
    EXPECT_FALSE(pair.used && result.scans[pair.target].robot != result.scans[pair.source].robot);
  }
}

}  // namespace
}  // namespace planegraph
