#include "planegraph/pipeline/mapper.h"

#include <gmock/gmock.h>

#include <cmath>
#include <fstream>

#include "pipeline/small_site.h"
#include "planegraph/base/angles.h"
#include "planegraph/evaluation/trajectory_error.h"
#include "planegraph/geometry/rotation.h"
#include "planegraph/pipeline/outputs.h"

namespace planegraph {
namespace {

using ::testing::AllOf;
using ::testing::Each;
using ::testing::ElementsAre;
using ::testing::EndsWith;
using ::testing::HasSubstr;
using ::testing::StartsWith;

// metres, aligned by least squares
double AteOf(const std::vector<Rigid3>& estimate, const std::vector<Rigid3>& truth) {
  Trajectory a, b;
  for (std::size_t i = 0; i < estimate.size(); ++i) {
    a.times.push_back(static_cast<double>(i));
    b.times.push_back(static_cast<double>(i));
  }
  a.poses = estimate, b.poses = truth;
  return ComputeAte(PairPoses(b, a), PoseAlignment::kFirst).errors.translation.rmse;
}

class MapSmallSite : public TestFolder {
 protected:
  Site WriteAndRead(const SimulatedSite& simulated, const std::string& name = "site") {
    WriteSite(Path(name), simulated);
    return ReadSite(Path(name) + "/site.yaml");
  }
};

TEST_F(MapSmallSite, YardComesOutAsItIs) {
  const SimulatedSite yard = SmallSite(SceneKind::kYard, 4, 10);
  const MapResult result = MapScans(WriteAndRead(yard), TwoThreads());
  EXPECT_EQ(result.components, 1);
  EXPECT_TRUE(result.warnings.empty());
  EXPECT_TRUE(result.solution.summary.usable);
  EXPECT_LT(AteOf(result.solution.world_from_scan, TruthFromFirst(yard)), 0.005);
  // The odometry is far worse, so that this says something.
  EXPECT_GT(AteOf(yard.robots[0].odometry, TruthFromFirst(yard)), 0.02);
}

TEST_F(MapSmallSite, TimesThatDoNotIncreaseAreAWarning) {
  Site site = WriteAndRead(SmallSite(SceneKind::kHall, 3, 16));
  site.robots[0].odometry->times = {7.0, 7.0, 7.0};
  const MapResult result = MapScans(site, TwoThreads("none"));
  EXPECT_THAT(result.warnings,
              ElementsAre(AllOf(StartsWith(site.robots[0].odometry_file),
                                HasSubstr("2 times do not increase, first that of pose 1 "),
                                EndsWith(": line k belongs to scan k"))));
  site.robots[0].odometry->has_times = false;
  EXPECT_TRUE(MapScans(site, TwoThreads("none")).warnings.empty());
}

TEST_F(MapSmallSite, MillimetresAreAskedFor) {
  SimulatedSite hall = SmallSite(SceneKind::kHall, 3, 16);
  EXPECT_TRUE(MapScans(WriteAndRead(hall), TwoThreads("none")).warnings.empty());
  for (std::size_t k = 1; k < 3; ++k) {
    for (Eigen::Vector3f& point : hall.robots[0].scans[k].cloud.points) point *= 1000.0F;
  }
  const MapResult result = MapScans(WriteAndRead(hall, "millimetres"), TwoThreads("none"));
  // Nothing that observes nothing counts as a registration.
  for (const PairRecord& pair : result.pairs) EXPECT_FALSE(pair.used) << pair.registration.reason;
  EXPECT_EQ(result.components, 3);
  EXPECT_THAT(result.warnings,
              ElementsAre("robot1: in 2 scans of 3 half of the points are farther than 100 m: are "
                          "the units metres?"));
}

TEST_F(MapSmallSite, WithoutOdometryScansAreRegisteredWithoutAGuess) {
  const SimulatedSite hall = SmallSite(SceneKind::kHall, 4, 16);
  Site site = WriteAndRead(hall);
  site.robots[0].odometry.reset();
  const MapResult result = MapScans(site, TwoThreads());
  EXPECT_TRUE(result.odometry.empty());
  EXPECT_EQ(result.components, 1);
  EXPECT_LT(AteOf(result.solution.world_from_scan, TruthFromFirst(hall)), 0.005);
}

TEST_F(MapSmallSite, AStartPoseIsTheWorld) {
  const SimulatedSite hall = SmallSite(SceneKind::kHall, 2, 16);
  Site site = WriteAndRead(hall);
  StartPose start;
  start.world_from_scan = hall.robots[0].truth.front();
  site.robots[0].start = start;
  const MapResult result = MapScans(site, TwoThreads());
  EXPECT_LT(LargestDistance(result.solution.world_from_scan, hall.robots[0].truth), 0.01);
}

TEST_F(MapSmallSite, TheCorridorsDirectionIsHeldByTheOdometry) {
  const SimulatedSite corridor = SmallSite(SceneKind::kCorridor, 4, 8);
  const MapResult result = MapScans(WriteAndRead(corridor), TwoThreads());
  EXPECT_EQ(result.components, 1);
  // The corridor runs along the simulation's x axis; the map's world is the first scan.
  const Eigen::Vector3d along =
      corridor.robots[0].truth.front().rotation.conjugate() * Eigen::Vector3d::UnitX();
  ASSERT_EQ(result.unobserved.size(), 4u);
  for (std::size_t i = 1; i < 4; ++i) {  // the first scan is the world
    SCOPED_TRACE(i);
    ASSERT_EQ(result.unobserved[i].size(), 1u);
    const UnobservedDirection& open = result.unobserved[i][0];
    EXPECT_GT(std::abs(open.direction.head<3>().dot(along)), std::cos(5 * kDegree));
    EXPECT_EQ(open.held_by, "odometry");
    EXPECT_GT(open.sigma, 0.05);
    const Eigen::Matrix3d covariance = result.covariances[i].topLeftCorner<3, 3>();
    const auto across = TangentBasis(along);
    EXPECT_LT(std::sqrt(across.col(0).dot(covariance * across.col(0))), 0.02);
    EXPECT_LT(std::sqrt(across.col(1).dot(covariance * across.col(1))), 0.02);
    // The position along it is the odometry's, not what noise adds up to.
    const Rigid3 step =
        corridor.robots[0].odometry[i - 1].Inverse() * corridor.robots[0].odometry[i];
    const Rigid3 found =
        result.solution.world_from_scan[i - 1].Inverse() * result.solution.world_from_scan[i];
    EXPECT_NEAR(found.translation.norm(), step.translation.norm(), 0.03);
  }
}

TEST_F(MapSmallSite, AnUnrelatedScanIsAComponentOfItsOwn) {
  SimulatedSite mixed = SmallSite(SceneKind::kYard, 3, 10);
  mixed.robots[0].scans[2] = SmallSite(SceneKind::kHall, 1, 16, 5).robots[0].scans[0];
  const MapResult result = MapScans(WriteAndRead(mixed), TwoThreads());
  EXPECT_EQ(result.components, 2);
  EXPECT_THAT(result.component, ElementsAre(0, 0, 1));
  for (const Rigid3& pose : result.solution.world_from_scan) {
    EXPECT_TRUE(pose.translation.allFinite());
  }
}

TEST_F(MapSmallSite, TheGraphIsAtLeastAsGoodAsTheChainAndTheMetascan) {
  const SimulatedSite hall = SmallSite(SceneKind::kHall, 4, 16);
  const Site site = WriteAndRead(hall);
  const auto truth = TruthFromFirst(hall);
  const auto error = [&](const std::string& optimizer) {
    const MapResult result = MapScans(site, TwoThreads(optimizer));
    EXPECT_EQ(result.components, 1) << optimizer;
    return AteOf(result.solution.world_from_scan, truth);
  };
  const double graph = error("graph"), metascan = error("metascan"), none = error("none");
  EXPECT_LT(graph, 0.005);
  EXPECT_LE(graph, 1.05 * none);
  EXPECT_LE(graph, 1.05 * metascan);
  EXPECT_LT(none, 0.05);
  EXPECT_LT(metascan, 0.05);
}

TEST_F(MapSmallSite, ComesBackFromDisturbedOdometry) {
  const SimulatedSite hall = SmallSite(SceneKind::kHall, 4, 16);
  Site site = WriteAndRead(hall);
  const MapResult undisturbed = MapScans(site, TwoThreads());
  Random random(7);
  for (Rigid3& pose : site.robots[0].odometry->poses) {
    Eigen::Vector3d shift, axis;
    for (int k = 0; k < 3; ++k) shift[k] = 0.3 * random.Normal();
    for (int k = 0; k < 3; ++k) axis[k] = random.Normal();
    pose.translation += shift;
    pose.rotation = ExpSO3(5 * kDegree * axis.normalized()) * pose.rotation;
  }
  const MapResult disturbed = MapScans(site, TwoThreads());
  EXPECT_EQ(disturbed.components, 1);
  EXPECT_LT(AteOf(disturbed.solution.world_from_scan, undisturbed.solution.world_from_scan), 0.02);
}

TEST_F(MapSmallSite, UnknownNamesAreWrongUsage) {
  const Site site = WriteAndRead(SmallSite(SceneKind::kHall, 2, 16));
  MapOptions options = TwoThreads("simplex");
  EXPECT_THROW(MapScans(site, options), UsageError);
  options = TwoThreads();
  options.plane_factor = "no_such_factor";
  EXPECT_THROW(MapScans(site, options), UsageError);
}

TEST_F(MapSmallSite, AMissingDroneCloudIsAnError) {
  Site site = WriteAndRead(SmallSite(SceneKind::kHall, 2, 16));
  site.maps.emplace_back();
  site.maps.back().name = "roof";
  site.maps.back().cloud = Path("roof.ply");
  EXPECT_THROW(MapScans(site, TwoThreads("none")), InputError);
}

TEST_F(MapSmallSite, OneScanIsItsOwnMap) {
  const Site site = WriteAndRead(SmallSite(SceneKind::kHall, 1, 16));
  for (const char* optimizer : {"graph", "metascan", "none"}) {
    SCOPED_TRACE(optimizer);
    const MapResult result = MapScans(site, TwoThreads(optimizer));
    EXPECT_EQ(result.components, 1);
    EXPECT_LT(result.solution.world_from_scan[0].translation.norm(), 1e-12);
    EXPECT_FALSE(ReportJson(result, TwoThreads(optimizer)).empty());
  }
}

TEST_F(MapSmallSite, AScanWithoutPlanesDoesNotStopTheRun) {
  const SimulatedSite hall = SmallSite(SceneKind::kHall, 2, 16);
  Site site = WriteAndRead(hall);
  Cloud few;
  for (int i = 0; i < 30; ++i) few.points.push_back(Eigen::Vector3f(3, 0.1f * i, 0.01f * i * i));
  WriteCloud(site.robots[0].scans[1], few);
  const MapResult result = MapScans(site, TwoThreads());
  EXPECT_EQ(result.components, 2);
  WriteOutputs(result, {Path("out"), 0.05, 2});
}

}  // namespace
}  // namespace planegraph
