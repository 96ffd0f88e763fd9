#include "planegraph/simulation/scene.h"

#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <tuple>

#include "planegraph/base/error.h"
#include "planegraph/simulation/laser_scanner.h"

namespace planegraph {
namespace {

class SceneTest : public testing::TestWithParam<std::tuple<SceneKind, int>> {
 protected:
  static constexpr double kMaxRange = 35.0;
  Scene scene_ = BuildScene(std::get<0>(GetParam()), std::get<1>(GetParam()), kMaxRange);
  RayCaster caster_{scene_.mesh};
  std::vector<Rigid3> poses_ = AllPoses();

 private:
  std::vector<Rigid3> AllPoses() const {
    std::vector<Rigid3> all;
    for (std::size_t k = 0; k < scene_.drives.size(); ++k) {
      const auto poses = DrivePath(scene_, caster_, scene_.drives[k].scans, PoseOptions(),
                                   std::get<1>(GetParam()), k);
      all.insert(all.end(), poses.begin(), poses.end());
    }
    return all;
  }
};

TEST_P(SceneTest, FacesLieOnTheirPlanes) {
  const LabelledMesh& mesh = scene_.mesh;
  ASSERT_EQ(mesh.labels.size(), mesh.triangles.size());
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
    if (mesh.labels[i] == kNotPlanar) continue;
    for (int k = 0; k < 3; ++k) {
      const Eigen::Vector3d& vertex = mesh.vertices[mesh.triangles[i][k]];
      ASSERT_NEAR(mesh.planes[mesh.labels[i]].SignedDistance(vertex), 0.0, 1e-9);
    }
  }
}

TEST_P(SceneTest, RobotStandsUprightOnTheGroundWithRoomAround) {
  for (const Rigid3& pose : poses_) {
    const Eigen::Vector3d up = pose.rotation * Eigen::Vector3d::UnitZ();
    EXPECT_GT(up.z(), std::cos(0.14)) << "slope and tilt are small";
    const auto ground = caster_.Cast(pose.translation, -up, kMaxRange);
    ASSERT_TRUE(ground.has_value());
    EXPECT_NEAR(ground->distance, 0.78, 0.05);
    for (int i = 0; i < 360; ++i) {
      const double azimuth = i * 3.14159265358979 / 180.0;
      const Eigen::Vector3d level(std::cos(azimuth), std::sin(azimuth), 0.0);
      const auto hit = caster_.Cast(pose.translation, level, kMaxRange);
      EXPECT_GT(hit ? hit->distance : kMaxRange, 0.35) << "at " << pose.translation.transpose();
    }
  }
}

// Seen from outside of all solids, every surface shows its outer side: the robot is in no wall, and
// no ray slips into one.
TEST_P(SceneTest, PlanesShowTheirOuterSideToTheScanner) {
  ScannerOptions options = ScannerOptions().WithoutNoise();
  options.beams = 181;
  options.sweeps = 45;
  for (const Rigid3& pose : poses_) {
    Random random(0);
    const LabelledScan scan = Scan(caster_, pose, options, &random);
    EXPECT_GT(scan.labels.size(), 3000u) << "most rays end somewhere";
    for (std::size_t i = 0; i < scan.labels.size(); ++i) {
      if (scan.labels[i] == kNotPlanar) continue;
      const Plane& plane = scene_.mesh.planes[scan.labels[i]];
      ASSERT_GT(plane.SignedDistance(pose.translation), 0.0)
          << "point " << (pose * scan.cloud.points[i].cast<double>().eval()).transpose() << " from "
          << pose.translation.transpose();
    }
  }
}

std::string ParameterName(const testing::TestParamInfo<SceneTest::ParamType>& info) {
  return SceneName(std::get<0>(info.param)) + std::to_string(std::get<1>(info.param));
}

INSTANTIATE_TEST_SUITE_P(AllScenes, SceneTest,
                         testing::Combine(testing::Values(SceneKind::kHall, SceneKind::kCorridor,
                                                          SceneKind::kYard, SceneKind::kQuarter),
                                          testing::Range(0, 8)),
                         ParameterName);

TEST(CorridorTest, NothingInRangeTellsWhereAlongItAScanWasTaken) {
  for (std::uint64_t seed = 0; seed < 5; ++seed) {
    ScannerOptions options = ScannerOptions().WithoutNoise();
    options.max_range = 12.0 + 6.0 * static_cast<double>(seed);
    const Scene scene = BuildScene(SceneKind::kCorridor, seed, options.max_range);
    const RayCaster caster(scene.mesh);
    for (const Rigid3& pose : DrivePath(scene, caster, 4, PoseOptions(), seed)) {
      // The same view from a place farther along the corridor.
      Rigid3 shifted = pose;
      shifted.translation.x() += pose.translation.x() < 10.0 ? 5.0 : -5.0;
      Random random(seed);
      options.beams = 271;
      options.sweeps = 60;
      const LabelledScan here = Scan(caster, pose, options, &random);
      const LabelledScan there = Scan(caster, shifted, options, &random);
      ASSERT_EQ(here.labels, there.labels);
      ASSERT_FALSE(here.labels.empty());
      for (std::size_t i = 0; i < here.labels.size(); ++i) {
        ASSERT_NE(here.labels[i], kNotPlanar);
        ASSERT_NEAR(scene.mesh.planes[here.labels[i]].normal.x(), 0.0, 1e-12);
        ASSERT_LT((here.cloud.points[i] - there.cloud.points[i]).norm(), 1e-4f);
      }
    }
  }
}

TEST_P(SceneTest, TheDronesAreaHoldsTheDrives) {
  for (const Rigid3& pose : poses_) {
    const Eigen::Vector2d at = pose.translation.head<2>();
    EXPECT_TRUE((at.array() > scene_.area_low.array() - 0.5).all()) << at.transpose();
    EXPECT_TRUE((at.array() < scene_.area_high.array() + 0.5).all()) << at.transpose();
  }
}

TEST(YardTest, TheLastScansStandDeepInTheHall) {
  for (std::uint64_t seed = 0; seed < 8; ++seed) {
    const Scene scene = BuildScene(SceneKind::kYard, seed, 35.0);
    const RayCaster caster(scene.mesh);
    const auto poses = DrivePath(scene, caster, scene.drives[0].scans, PoseOptions(), seed);
    const auto under_roof = [&](const Rigid3& pose) {
      return caster.Cast(pose.translation, Eigen::Vector3d::UnitZ(), 20.0).has_value();
    };
    EXPECT_FALSE(under_roof(poses[0]) || under_roof(poses[3]));
    EXPECT_TRUE(under_roof(poses.back()) && under_roof(poses[poses.size() - 2]));
    EXPECT_GT(poses.back().translation.y(), 13.0 + 8.0) << "the gate is at 13 m";
  }
}

class QuarterTest : public testing::TestWithParam<int> {
 protected:
  std::vector<Rigid3> Poses(std::size_t drive) const {
    return DrivePath(scene_, caster_, scene_.drives[drive].scans, PoseOptions(), GetParam(), drive);
  }
  bool Visible(const Eigen::Vector3d& from, const Eigen::Vector3d& to) const {
    const double distance = (to - from).norm();
    const auto hit = caster_.Cast(from, (to - from) / distance, distance);
    return !hit || hit->distance > distance - 1e-3;
  }
  // The planes, but those of ground and roofs, that a robot's scans show with many points.
  std::map<int, int> Walls(std::size_t drive) const {
    std::map<int, int> points;
    ScannerOptions options = ScannerOptions().WithoutNoise();
    options.beams = 271;
    options.sweeps = 60;
    for (const Rigid3& pose : Poses(drive)) {
      Random random(0);
      for (const int label : Scan(caster_, pose, options, &random).labels) {
        if (label != kNotPlanar && std::abs(scene_.mesh.planes[label].normal.z()) < 0.5) {
          ++points[label];
        }
      }
    }
    return points;
  }

  Scene scene_ = BuildScene(SceneKind::kQuarter, GetParam(), 35.0);
  RayCaster caster_{scene_.mesh};
};

TEST_P(QuarterTest, NoRobotSeesTheStartOfTheOther) {
  ASSERT_EQ(scene_.drives.size(), 2u);
  for (const std::size_t k : {0, 1}) {
    const Eigen::Vector3d start = Poses(1 - k).front().translation;
    for (const Rigid3& pose : Poses(k)) {
      EXPECT_FALSE(Visible(pose.translation, start)) << pose.translation.transpose();
    }
  }
}

TEST_P(QuarterTest, RobotsShareLittleOfTheWalls) {
  const auto first = Walls(0), second = Walls(1);
  int shared = 0, all = 0;
  for (const auto& [label, points] : second) {
    all += points;
    if (first.count(label)) shared += std::min(points, first.at(label));
  }
  EXPECT_LT(shared, 0.15 * all);
}

TEST_P(QuarterTest, OneRobotEndsUnderARoof) {
  const Eigen::Vector3d last = Poses(1).back().translation;
  EXPECT_TRUE(caster_.Cast(last, Eigen::Vector3d::UnitZ(), 20.0).has_value());
}

INSTANTIATE_TEST_SUITE_P(Seeds, QuarterTest, testing::Range(0, 8));

TEST(SceneNameTest, RoundTripAndUnknownName) {
  for (const auto kind :
       {SceneKind::kHall, SceneKind::kCorridor, SceneKind::kYard, SceneKind::kQuarter}) {
    EXPECT_EQ(ParseSceneKind(SceneName(kind)), kind);
  }
  EXPECT_THROW(ParseSceneKind("cellar"), UsageError);
}

}  // namespace
}  // namespace planegraph
