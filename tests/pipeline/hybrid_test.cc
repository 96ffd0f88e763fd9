// Sites with a drone map, from files to poses.
#include <gmock/gmock.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <mutex>
#include <nlohmann/json.hpp>
#include <sstream>

#include "io/test_files.h"
#include "planegraph/base/error.h"
#include "planegraph/io/camera_io.h"
#include "planegraph/io/cloud_io.h"
#include "planegraph/pipeline/mapper.h"
#include "planegraph/pipeline/outputs.h"
#include "planegraph/simulation/simulation.h"

namespace planegraph {
namespace {

using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

SimulatedSite Hybrid(SceneKind scene, std::uint64_t seed, int scans) {
  SimulationOptions options;
  options.scene = scene;
  options.seed = seed;
  options.scans = scans;
  options.scanner.beams = 361;
  options.scanner.sweeps = 120;
  return Simulate(options);
}

MapOptions Options(const std::string& optimizer) {
  MapOptions options;
  options.optimizer = optimizer;
  options.threads = 2;
  return options;
}

// Relative error of the map's scale.
double ScaleError(const MapResult& result, const SimulatedSite& site) {
  const Sim3 found = result.solution.world_from_metric[0] * result.maps[0].metric_from_map;
  return found.scale / site.drone->model.world_from_map.scale - 1.0;
}

// Largest error of a robot's positions in the map's own frame, metres: free of the GPS bias.
double LargestInMap(const MapResult& result, const SimulatedSite& site, std::size_t robot) {
  const Sim3 map_from_world =
      (result.solution.world_from_metric[0] * result.maps[0].metric_from_map).Inverse();
  const Sim3& truth = site.drone->model.world_from_map;
  double largest = 0.0;
  for (std::size_t i = 0; i < result.scans.size(); ++i) {
    if (result.scans[i].robot != robot) continue;
    const Eigen::Vector3d in_map = map_from_world * result.solution.world_from_scan[i].translation;
    const Eigen::Vector3d want = site.robots[robot].truth[result.scans[i].index].translation;
    largest = std::max(largest, (truth * in_map - want).norm());
  }
  return largest;
}

std::size_t Anchored(const MapResult& result) {
  std::size_t count = 0;
  for (const auto& pair : result.map_pairs) count += pair.used ? 1 : 0;
  return count;
}

class HybridYard : public TestFolder {
 protected:
  HybridYard() { WriteSite(Path("site"), yard_); }
  Site Read(const std::string& name) const { return ReadSite(Path("site/" + name)); }

  // The GPS track stretched about its centre, as a scale error of the receiver would do.
  void StretchGps(double factor) const {
    std::ifstream in(Path("site/uav/gps.csv"));
    std::string header, line;
    std::getline(in, header);
    std::vector<std::array<double, 4>> rows;
    while (std::getline(in, line)) {
      std::replace(line.begin(), line.end(), ',', ' ');
      auto& row = rows.emplace_back();
      std::istringstream(line) >> row[0] >> row[1] >> row[2] >> row[3];
    }
    std::array<double, 4> mean{};
    for (const auto& row : rows) {
      for (int k = 1; k < 4; ++k) mean[k] += row[k] / static_cast<double>(rows.size());
    }
    std::ofstream out(Path("site/uav/gps.csv"));
    out.precision(12);
    out << header << "\n";
    for (const auto& row : rows) {
      out << row[0];
      for (int k = 1; k < 4; ++k) out << "," << mean[k] + factor * (row[k] - mean[k]);
      out << "\n";
    }
  }

  const SimulatedSite yard_ = Hybrid(SceneKind::kYard, 3, 9);
};

TEST_F(HybridYard, JoinsLaserAndDrone) {
  for (const char* name : {"site.yaml", "site_nostart.yaml"}) {
    SCOPED_TRACE(name);
    const MapResult result = MapScans(Read(name), Options("graph"));
    EXPECT_EQ(result.components, 1);
    EXPECT_GE(Anchored(result), 2u);
    EXPECT_LT(std::abs(ScaleError(result, yard_)), 0.005);
    EXPECT_LT(std::abs(ScaleError(result, yard_)),
              3.0 * std::sqrt(result.map_covariances[0](6, 6)));
    EXPECT_LT(LargestInMap(result, yard_, 0), 0.15);
  }
}

// Largest error of the robot's positions in the world, metres.
double LargestInWorld(const MapResult& result, const SimulatedSite& site) {
  double largest = 0.0;
  for (std::size_t i = 0; i < result.scans.size(); ++i) {
    largest = std::max(largest, (result.solution.world_from_scan[i].translation -
                                 site.robots[0].truth[i].translation)
                                    .norm());
  }
  return largest;
}

TEST_F(HybridYard, ARobotsReceiverPlacesTheSiteOnTheEarth) {
  Site site = Read("site_gps.yaml");
  ASSERT_TRUE(site.robots[0].gps.has_value());
  const MapResult noisy = MapScans(site, Options("graph"));
  EXPECT_EQ(noisy.components, 1);
  EXPECT_EQ(noisy.robot_positions.size(), noisy.scans.size());
  EXPECT_LT(LargestInMap(noisy, yard_, 0), 0.15);
  // Positions to the centimetre settle what the drone's receiver, off by a metre, leaves open.
  SimulatedGps exact = yard_.robots[0].gps;
  exact.times = yard_.robots[0].times;
  exact.positions.clear();
  for (const Rigid3& pose : yard_.robots[0].truth) exact.positions.push_back(pose * kAntenna);
  std::ofstream(Path("site/gps.csv")) << GpsText(exact, yard_.drone->origin);
  site.robots[0].gps->sigma = 0.01;
  const MapResult placed = MapScans(site, Options("graph"));
  EXPECT_EQ(placed.components, 1);
  EXPECT_LT(LargestInWorld(placed, yard_), 0.05);
  EXPECT_GT(LargestInWorld(MapScans(Read("site.yaml"), Options("graph")), yard_), 0.1);
}

TEST_F(HybridYard, WithoutAMapOnTheEarthReceiversAreLeftOutWithAWarning) {
  Site site = Read("site_laser_only.yaml");
  site.robots[0].gps = Read("site_gps.yaml").robots[0].gps;
  const MapResult result = MapScans(site, Options("graph"));
  EXPECT_TRUE(result.robot_positions.empty());
  EXPECT_FALSE(result.warnings.empty());
}

TEST_F(HybridYard, AMapWithoutGpsSaysWhatIsTakenForGranted) {
  const auto warnings = [](const Site& site) {
    std::vector<std::string> list;
    PrepareMap(site, 0, 1, &list);
    return list;
  };
  Site site = Read("site.yaml");
  EXPECT_THAT(warnings(site), IsEmpty());
  site.maps[0].gps.clear();
  EXPECT_THAT(warnings(site), ElementsAre(HasSubstr("its unit is taken for the metre")));
  site.maps[0].scale = 8.5;
  EXPECT_THAT(warnings(site), IsEmpty());
}

TEST_F(HybridYard, AScaleBesidePositionsIsNotUsed) {
  Site site = Read("site.yaml");
  std::vector<std::string> warnings;
  const double by_gps = PrepareMap(site, 0, 1, &warnings).metric_from_map.scale;
  site.maps[0].scale = 2.0;
  EXPECT_EQ(PrepareMap(site, 0, 1, &warnings).metric_from_map.scale, by_gps);
  EXPECT_THAT(warnings, ElementsAre(HasSubstr("`scale` is not used")));
  site.maps[0].gps.clear();
  EXPECT_EQ(PrepareMap(site, 0, 1, &warnings).metric_from_map.scale, 2.0);
}

TEST_F(HybridYard, AnOriginFarFromTheFlightIsNamed) {
  Site site = Read("site.yaml");
  ASSERT_TRUE(site.origin.has_value());
  std::swap(site.origin->latitude, site.origin->longitude);
  std::vector<std::string> warnings;
  PrepareMap(site, 0, 1, &warnings);
  EXPECT_THAT(warnings, ElementsAre(HasSubstr("are latitude and longitude exchanged")));
}

// A user who waits wants to know why.
TEST_F(HybridYard, WarningsComeWhenTheyArise) {
  Site site = Read("site.yaml");
  site.maps[0].scale = 2.0;
  MapOptions options = Options("graph");
  std::vector<std::string> events;
  std::vector<double> placing;
  std::mutex mutex;
  options.warn = [&](const std::string& text) {
    const std::lock_guard lock(mutex);
    events.push_back(text);
  };
  options.progress = [&](const std::string& stage, double done) {
    const std::lock_guard lock(mutex);
    events.push_back(stage);
    if (stage == "placing") placing.push_back(done);
  };
  const MapResult result = MapScans(site, options);
  ASSERT_THAT(result.warnings, ElementsAre(HasSubstr("`scale` is not used")));
  const auto warning = std::find(events.begin(), events.end(), result.warnings[0]);
  EXPECT_LT(warning, std::find(events.begin(), events.end(), "placing"));
  EXPECT_EQ(std::count(events.begin(), events.end(), result.warnings[0]), 1);
  // And how long it will be: no step of the search takes more than half of the whole.
  std::sort(placing.begin(), placing.end());
  EXPECT_EQ(placing.front(), 0.0);
  EXPECT_EQ(placing.back(), 1.0);
  for (std::size_t i = 1; i < placing.size(); ++i) EXPECT_LE(placing[i] - placing[i - 1], 0.5);
}

// Of the model's cloud, which is also where its sparse points lie, a part, or all of it moved.
TEST_F(HybridYard, ACloudInAnotherFrameThanItsCamerasIsNamed) {
  const Site site = Read("site.yaml");
  const Cloud cloud = ReadCloud(site.maps[0].cloud);
  CameraModel model = ReadCameras(site.maps[0].cameras);
  for (std::size_t i = 0; i < cloud.size(); i += cloud.size() / 1000) {
    model.points.push_back(cloud.Position(i));
  }
  WriteMveCameras(site.maps[0].cameras, model);
  const auto warnings = [&](const Cloud& other) {
    WriteCloud(site.maps[0].cloud, other);
    std::vector<std::string> list;
    PrepareMap(site, 0, 1, &list);
    return list;
  };
  const auto moved = [&](const Sim3& motion) {
    Cloud other = cloud;
    for (auto& point : other.points) point = (motion * point.cast<double>()).cast<float>();
    return other;
  };
  std::vector<float> x;
  for (const auto& point : cloud.points) x.push_back(point.x());
  std::sort(x.begin(), x.end());
  const auto part = [&](double share) {
    const float most = x[static_cast<std::size_t>(share * static_cast<double>(x.size()))];
    std::vector<std::uint32_t> indices;
    for (std::uint32_t i = 0; i < cloud.size(); ++i) {
      if (cloud.points[i].x() < most) indices.push_back(i);
    }
    return Select(cloud, indices);
  };
  EXPECT_THAT(warnings(cloud), IsEmpty());
  EXPECT_THAT(warnings(part(0.5)), IsEmpty());
  EXPECT_THAT(warnings(part(0.1)), IsEmpty());
  const Eigen::Quaterniond turn(Eigen::AngleAxisd(1.0, Eigen::Vector3d::UnitX()));
  for (const Sim3& motion :
       {Sim3(8.0, Eigen::Quaterniond::Identity(), {300.0, 200.0, 10.0}),
        Sim3(1.0, turn, {100.0, 0.0, 0.0}), Sim3(7.0, turn, Eigen::Vector3d::Zero())}) {
    EXPECT_THAT(warnings(moved(motion)), ElementsAre(HasSubstr("are both in one frame?")));
  }
}

TEST_F(HybridYard, PositionsByTimeWithoutTheImagesTimesAreTheFilesError) {
  Site site = Read("site.yaml");
  site.maps[0].image_times.clear();
  try {
    MapScans(site, Options("none"));
    FAIL() << "nothing is missing";
  } catch (const InputError& error) {
    EXPECT_THAT(error.what(), AllOf(HasSubstr(site.maps[0].gps), HasSubstr("`image_times`")));
  }
}

TEST_F(HybridYard, KnownTiltsHoldTheVertical) {
  Site site = Read("site.yaml");
  // What the truth says of the vertical in the map's own frame; the cameras' positions, which err
  // by metres, leave a tenth of a degree.
  const Sim3& truth = yard_.drone->model.world_from_map;
  site.maps[0].gravity = GravityPrior{truth.rotation.conjugate() * Eigen::Vector3d::UnitZ(), 1e-5};
  const MapResult result = MapScans(site, Options("graph"));
  const Sim3 found = result.solution.world_from_metric[0] * result.maps[0].metric_from_map;
  const Eigen::Vector3d up = found.rotation * site.maps[0].gravity->up;
  EXPECT_LT((up - Eigen::Vector3d::UnitZ()).norm(), 2e-4);
}

TEST_F(HybridYard, TheMapDoesNotBendTheWay) {
  const MapResult with = MapScans(Read("site.yaml"), Options("graph"));
  const MapResult without = MapScans(Read("site_laser_only.yaml"), Options("graph"));
  for (std::size_t i = 1; i < with.scans.size(); ++i) {
    const auto relative = [i](const MapResult& r) {
      return r.solution.world_from_scan[i - 1].Inverse() * r.solution.world_from_scan[i];
    };
    EXPECT_LT((relative(with).translation - relative(without).translation).norm(), 0.003);
  }
}

TEST_F(HybridYard, EveryOptimizerTakesMaps) {
  for (const char* optimizer : {"metascan", "none"}) {
    SCOPED_TRACE(optimizer);
    const MapResult result = MapScans(Read("site.yaml"), Options(optimizer));
    EXPECT_GE(Anchored(result), 2u);
    EXPECT_LT(LargestInMap(result, yard_, 0), 0.3);
    EXPECT_FALSE(ReportJson(result, Options(optimizer)).empty());
  }
}

TEST_F(HybridYard, PlanesWithoutLandmarksTakeMapsToo) {
  MapOptions options = Options("graph");
  options.plane_factor = "pose_pose";
  const MapResult result = MapScans(Read("site.yaml"), options);
  EXPECT_LT(std::abs(ScaleError(result, yard_)), 0.005);
  EXPECT_LT(LargestInMap(result, yard_, 0), 0.15);
}

TEST_F(HybridYard, ATrackOfTheWrongScaleIsMendedByTheLaserOrRefused) {
  StretchGps(0.8);
  Site site = Read("site_nostart.yaml");
  site.maps[0].scale_sigma = 0.25;
  const MapResult result = MapScans(site, Options("graph"));
  if (Anchored(result) > 0) {
    EXPECT_LT(std::abs(ScaleError(result, yard_)), 0.005);
  } else {
    ASSERT_FALSE(result.map_pairs.empty());
    EXPECT_FALSE(result.map_pairs[0].reason.empty());
  }
}

TEST_F(HybridYard, AMapWithoutPositionsComesToTheRobot) {
  Site site = Read("site_nostart.yaml");
  site.maps[0].gps.clear();
  site.maps[0].scale = 1.01 * yard_.drone->model.world_from_map.scale;
  site.maps[0].scale_sigma = 0.02;
  const MapResult result = MapScans(site, Options("graph"));
  EXPECT_EQ(result.components, 1);
  EXPECT_GE(Anchored(result), 2u);
  EXPECT_LT(result.solution.world_from_scan[0].translation.norm(), 1e-9)
      << "the first scan is the world";
  EXPECT_LT(std::abs(ScaleError(result, yard_)), 0.005);
}

TEST_F(HybridYard, AMapOfAnotherPlaceIsLeftAlone) {
  const SimulatedSite other = Hybrid(SceneKind::kQuarter, 8, 2);
  WriteSite(Path("other"), other);
  Site site = Read("site_nostart.yaml");
  site.maps = ReadSite(Path("other/site.yaml")).maps;
  const MapResult result = MapScans(site, Options("graph"));
  EXPECT_EQ(Anchored(result), 0u);
  EXPECT_EQ(result.components, 1);
  ASSERT_FALSE(result.map_pairs.empty());
  EXPECT_FALSE(result.map_pairs[0].reason.empty());
  const auto report = nlohmann::json::parse(ReportJson(result, Options("graph")));
  EXPECT_TRUE(report["maps"][0]["sigma_scale"].is_null()) << "no scan says anything of its scale";
  EXPECT_TRUE(report["maps"][0]["covariance"].is_null());
}

// Scans deep in a hall, of which the drone saw the outside alone: all their poses in the map are
// wrong, and about as good as each other.
TEST(HybridData, TheBestCandidateComesFirst) {
  const std::string base = PLANEGRAPH_SHARED_DATA "/hybrid-site-a";
  if (!std::filesystem::exists(base)) GTEST_SKIP() << "no " << base;
  const Site site = ReadSite(base + "/site_loop_nostart.yaml");
  std::vector<std::string> warnings;
  const MapRecord map = PrepareMap(site, 0, 2, &warnings);
  const MapModel model(map.planes);
  for (const std::size_t scan : {5u, 7u, 9u}) {
    SCOPED_TRACE(scan);
    const ScanRecord record = PrepareScan(site, 0, scan, {});
    const ScanModel scan_model(record.planes);
    MapLocationOptions options;
    options.threads = 2;
    options.prior.upright = true;
    options.prior.sigma_scale = map.sigma_scale;
    const MapLocation found = LocateInMap(model, ScanGroup(scan_model), options);
    EXPECT_GE(found.r1, found.r2);
    EXPECT_LE(found.chance, 1.0);
    EXPECT_NE(found.status, RegistrationStatus::kOk);
  }
}

class HybridQuarter : public TestFolder {};

TEST_F(HybridQuarter, RobotsThatNeverMetAreJoinedByTheMap) {
  const SimulatedSite quarter = Hybrid(SceneKind::kQuarter, 5, 8);
  WriteSite(Path("site"), quarter);
  const MapResult result = MapScans(ReadSite(Path("site/site_nostart.yaml")), Options("graph"));
  EXPECT_EQ(result.components, 1);
  EXPECT_LT(LargestInMap(result, quarter, 0), 0.15);
  EXPECT_LT(LargestInMap(result, quarter, 1), 0.15);
  ASSERT_EQ(result.bridges.size() + 1, 2u) << "one edge joins the robots in the pose graph";
}

}  // namespace
}  // namespace planegraph
