#include "planegraph/simulation/simulation.h"

#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <map>

#include "planegraph/base/atomic_file.h"
#include "planegraph/base/error.h"
#include "planegraph/io/cloud_io.h"
#include "planegraph/io/trajectory_io.h"

namespace planegraph {
namespace {

SimulationOptions SmallOptions(SceneKind scene, std::uint64_t seed = 5) {
  SimulationOptions options;
  options.scene = scene;
  options.seed = seed;
  options.scans = 3;
  options.scanner.beams = 136;
  options.scanner.sweeps = 45;
  options.drone_mode = DroneMode::kOff;
  return options;
}

class Folder {
 public:
  Folder() {
    std::string pattern = (std::filesystem::temp_directory_path() / "simulation-XXXXXX").string();
    path_ = mkdtemp(pattern.data());
  }
  ~Folder() { std::filesystem::remove_all(path_); }
  std::string operator/(const std::string& name) const { return path_ + "/" + name; }

  std::map<std::string, std::string> Contents() const {
    std::map<std::string, std::string> contents;
    for (const auto& entry : std::filesystem::recursive_directory_iterator(path_)) {
      if (!entry.is_regular_file()) continue;
      contents[entry.path().string().substr(path_.size())] = ReadTextFile(entry.path().string());
    }
    return contents;
  }

 private:
  std::string path_;
};

class SimulationTest : public testing::TestWithParam<SceneKind> {};

TEST_P(SimulationTest, NoiseFreePointsLieOnTheirPlanesUnderTheTruePoses) {
  SimulationOptions options = SmallOptions(GetParam());
  options.scanner = options.scanner.WithoutNoise();
  const SimulatedSite site = Simulate(options);
  const SimulatedRobot& robot = site.robots.back();
  ASSERT_EQ(robot.scans.size(), 3u);
  for (std::size_t k = 0; k < robot.scans.size(); ++k) {
    const LabelledScan& scan = robot.scans[k];
    ASSERT_EQ(scan.labels.size(), scan.cloud.size());
    std::size_t planar = 0;
    for (std::size_t i = 0; i < scan.labels.size(); ++i) {
      if (scan.labels[i] == kNotPlanar) continue;
      ++planar;
      const Eigen::Vector3d point = robot.truth[k] * scan.cloud.Position(i);
      ASSERT_NEAR(site.planes.at(scan.labels[i]).SignedDistance(point), 0.0, 1e-4);
    }
    EXPECT_GT(planar, scan.labels.size() / 2);
  }
}

TEST_P(SimulationTest, EachScanHasAPoseATimeAndOdometry) {
  for (const SimulatedRobot& robot : Simulate(SmallOptions(GetParam())).robots) {
    ASSERT_EQ(robot.truth.size(), robot.scans.size());
    ASSERT_EQ(robot.times.size(), robot.scans.size());
    ASSERT_EQ(robot.odometry.size(), robot.scans.size());
    EXPECT_EQ(robot.odometry[0].Matrix(), Eigen::Matrix4d::Identity());
    for (std::size_t k = 1; k < robot.times.size(); ++k) {
      EXPECT_GT(robot.times[k], robot.times[k - 1]);
      const Rigid3 error =
          robot.odometry[k].Inverse() * (robot.truth[0].Inverse() * robot.truth[k]);
      EXPECT_GT(error.translation.norm(), 1e-3) << "odometry drifts";
      EXPECT_LT(error.translation.norm(), 3.0) << "but is of use";
    }
  }
}

TEST_P(SimulationTest, EqualSeedsGiveEqualBytesForAnyThreads) {
  SimulationOptions options = SmallOptions(GetParam());
  Folder first, second, third;
  options.threads = 1;
  WriteSite(first / "", Simulate(options));
  options.threads = 3;
  WriteSite(second / "", Simulate(options));
  options.seed += 1;
  WriteSite(third / "", Simulate(options));
  const auto contents = first.Contents();
  const std::size_t robots = GetParam() == SceneKind::kQuarter ? 2 : 1;
  EXPECT_EQ(contents.size(), robots * (3u + 3u + 2u) + 2u);
  EXPECT_TRUE(contents == second.Contents());
  for (const auto& [name, bytes] : third.Contents()) {
    ASSERT_TRUE(contents.count(name)) << name;
    EXPECT_NE(bytes, contents.at(name)) << name;
  }
}

INSTANTIATE_TEST_SUITE_P(AllScenes, SimulationTest,
                         testing::Values(SceneKind::kHall, SceneKind::kCorridor, SceneKind::kYard,
                                         SceneKind::kQuarter),
                         [](const auto& scene) { return SceneName(scene.param); });

TEST(WriteSiteTest, FilesHoldWhatWasSimulated) {
  const SimulatedSite site = Simulate(SmallOptions(SceneKind::kYard));
  const SimulatedRobot& robot = site.robots.at(0);
  Folder folder;
  WriteSite(folder / "site", site);
  for (std::size_t k = 0; k < robot.scans.size(); ++k) {
    const std::string name = "scan00" + std::to_string(k) + ".ply";
    EXPECT_EQ(ReadCloud(folder / ("site/scans/" + name)).points, robot.scans[k].cloud.points);
    const std::string labelled = folder / ("site/truth/labels/" + name);
    EXPECT_EQ(ReadCloud(labelled).points, robot.scans[k].cloud.points);
    EXPECT_NE(ReadTextFile(labelled).find("property int plane\n"), std::string::npos);
    EXPECT_EQ(ReadTextFile(folder / ("site/scans/" + name)).find("property int"),
              std::string::npos);
  }
  const Trajectory truth = ReadTrajectory(folder / "site/truth.tum");
  const Trajectory odometry = ReadTrajectory(folder / "site/odometry.tum");
  EXPECT_EQ(truth.times, robot.times);
  EXPECT_EQ(odometry.times, robot.times);
  for (std::size_t k = 0; k < robot.truth.size(); ++k) {
    EXPECT_EQ(truth.poses[k].translation, robot.truth[k].translation);
    EXPECT_EQ(odometry.poses[k].translation, robot.odometry[k].translation);
  }
}

TEST(WriteSiteTest, RemovesScansOfALongerRun) {
  SimulationOptions options = SmallOptions(SceneKind::kCorridor);
  Folder folder;
  WriteSite(folder / "", Simulate(options));
  EXPECT_EQ(folder.Contents().count("/scans/scan002.ply"), 1u);
  options.scans = 2;
  WriteSite(folder / "", Simulate(options));
  EXPECT_EQ(folder.Contents().size(), 2u + 2u + 4u);
}

TEST(WriteSiteTest, RobotsHaveFoldersOfTheirOwn) {
  const SimulatedSite site = Simulate(SmallOptions(SceneKind::kQuarter));
  Folder folder;
  WriteSite(folder / "", site);
  for (const SimulatedRobot& robot : site.robots) {
    const std::string own = folder / (robot.name + "/");
    EXPECT_EQ(ReadCloud(own + "scans/scan002.ply").points, robot.scans[2].cloud.points);
    EXPECT_EQ(ReadTrajectory(own + "truth.tum").times, robot.times);
    EXPECT_EQ(ReadTrajectory(own + "odometry.tum").times, robot.times);
    EXPECT_EQ(ReadCloud(folder / ("truth/labels/" + robot.name + "/scan000.ply")).points,
              robot.scans[0].cloud.points);
  }
}

TEST(DroneModeTest, AutoIsForScenesOutOfDoors) {
  EXPECT_EQ(ParseDroneMode("auto"), DroneMode::kAuto);
  EXPECT_EQ(ParseDroneMode("on"), DroneMode::kOn);
  EXPECT_EQ(ParseDroneMode("off"), DroneMode::kOff);
  EXPECT_THROW(ParseDroneMode("maybe"), UsageError);
  for (const auto kind :
       {SceneKind::kHall, SceneKind::kCorridor, SceneKind::kYard, SceneKind::kQuarter}) {
    SimulationOptions options = SmallOptions(kind);
    options.drone_mode = DroneMode::kAuto;
    options.drone.photogrammetry.pixel_step = 80;
    const bool outside = kind == SceneKind::kYard || kind == SceneKind::kQuarter;
    const SimulatedSite site = Simulate(options);
    EXPECT_EQ(site.drone.has_value(), outside);
    EXPECT_EQ(site.robots[0].start.has_value(), outside);
  }
}

TEST(SimulateTest, RefusesOptionsWithoutSense) {
  SimulationOptions negative, many;
  negative.scans = -1;
  many.scans = 1001;
  EXPECT_THROW(Simulate(negative), UsageError);
  EXPECT_THROW(Simulate(many), UsageError);
}

}  // namespace
}  // namespace planegraph
