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
  ASSERT_EQ(site.scans.size(), 3u);
  for (std::size_t k = 0; k < site.scans.size(); ++k) {
    const LabelledScan& scan = site.scans[k];
    ASSERT_EQ(scan.labels.size(), scan.cloud.size());
    std::size_t planar = 0;
    for (std::size_t i = 0; i < scan.labels.size(); ++i) {
      if (scan.labels[i] == kNotPlanar) continue;
      ++planar;
      const Eigen::Vector3d point = site.truth[k] * scan.cloud.Position(i);
      ASSERT_NEAR(site.planes.at(scan.labels[i]).SignedDistance(point), 0.0, 1e-4);
    }
    EXPECT_GT(planar, scan.labels.size() / 2);
  }
}

TEST_P(SimulationTest, EachScanHasAPoseATimeAndOdometry) {
  const SimulatedSite site = Simulate(SmallOptions(GetParam()));
  ASSERT_EQ(site.truth.size(), site.scans.size());
  ASSERT_EQ(site.times.size(), site.scans.size());
  ASSERT_EQ(site.odometry.size(), site.scans.size());
  EXPECT_EQ(site.odometry[0].Matrix(), Eigen::Matrix4d::Identity());
  for (std::size_t k = 1; k < site.times.size(); ++k) {
    EXPECT_GT(site.times[k], site.times[k - 1]);
    const Rigid3 error = site.odometry[k].Inverse() * (site.truth[0].Inverse() * site.truth[k]);
    EXPECT_GT(error.translation.norm(), 1e-3) << "odometry drifts";
    EXPECT_LT(error.translation.norm(), 3.0) << "but is of use";
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
  EXPECT_EQ(contents.size(), 3u + 3u + 4u);
  EXPECT_TRUE(contents == second.Contents());
  for (const auto& [name, bytes] : third.Contents()) {
    ASSERT_TRUE(contents.count(name)) << name;
    EXPECT_NE(bytes, contents.at(name)) << name;
  }
}

INSTANTIATE_TEST_SUITE_P(AllScenes, SimulationTest,
                         testing::Values(SceneKind::kHall, SceneKind::kCorridor, SceneKind::kYard),
                         [](const auto& scene) { return SceneName(scene.param); });

TEST(WriteSiteTest, FilesHoldWhatWasSimulated) {
  const SimulatedSite site = Simulate(SmallOptions(SceneKind::kYard));
  Folder folder;
  WriteSite(folder / "site", site);
  for (std::size_t k = 0; k < site.scans.size(); ++k) {
    const std::string name = "scan00" + std::to_string(k) + ".ply";
    EXPECT_EQ(ReadCloud(folder / ("site/scans/" + name)).points, site.scans[k].cloud.points);
    const std::string labelled = folder / ("site/truth/labels/" + name);
    EXPECT_EQ(ReadCloud(labelled).points, site.scans[k].cloud.points);
    EXPECT_NE(ReadTextFile(labelled).find("property int plane\n"), std::string::npos);
    EXPECT_EQ(ReadTextFile(folder / ("site/scans/" + name)).find("property int"),
              std::string::npos);
  }
  const Trajectory truth = ReadTrajectory(folder / "site/truth.tum");
  const Trajectory odometry = ReadTrajectory(folder / "site/odometry.tum");
  EXPECT_EQ(truth.times, site.times);
  EXPECT_EQ(odometry.times, site.times);
  for (std::size_t k = 0; k < site.truth.size(); ++k) {
    EXPECT_EQ(truth.poses[k].translation, site.truth[k].translation);
    EXPECT_EQ(odometry.poses[k].translation, site.odometry[k].translation);
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

TEST(SimulateTest, RefusesOptionsWithoutSense) {
  SimulationOptions negative, many;
  negative.scans = -1;
  many.scans = 1001;
  EXPECT_THROW(Simulate(negative), UsageError);
  EXPECT_THROW(Simulate(many), UsageError);
}

}  // namespace
}  // namespace planegraph
