#include "planegraph/simulation/drone.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>
#include <sstream>

#include "io/test_files.h"
#include "planegraph/base/atomic_file.h"
#include "planegraph/geometry/rotation.h"
#include "planegraph/io/cloud_io.h"
#include "planegraph/io/trajectory_io.h"
#include "planegraph/simulation/simulation.h"

namespace planegraph {
namespace {

using Eigen::Vector3d;
using ::testing::HasSubstr;
using ::testing::Not;
using ::testing::StartsWith;

std::vector<std::string> Lines(const std::string& path) {
  std::istringstream text(ReadTextFile(path));
  std::vector<std::string> lines;
  for (std::string line; std::getline(text, line);) lines.push_back(line);
  return lines;
}

std::vector<double> Numbers(std::string text) {
  for (char& c : text) c = c == ',' ? ' ' : c;
  std::istringstream stream(text);
  std::vector<double> numbers;
  for (double value; stream >> value;) numbers.push_back(value);
  return numbers;
}

Sim3 ReadSimilarity(const std::string& path) {
  const auto json = nlohmann::json::parse(ReadTextFile(path));
  Eigen::Matrix3d rotation;
  for (int i = 0; i < 3; ++i) {
    for (int k = 0; k < 3; ++k) rotation(i, k) = json["R"][i][k];
  }
  return {json["scale"], Eigen::Quaterniond(rotation),
          Vector3d(json["t"][0], json["t"][1], json["t"][2])};
}

// East-north-up by the curvature radii of WGS84 at the origin: good to a millimetre within 50 m.
Vector3d LocalFromGeodetic(double latitude, double longitude, double altitude) {
  constexpr double kDegree = 3.141592653589793 / 180.0, kA = 6378137.0, kE2 = 6.69437999014e-3;
  const GeodeticPosition origin = DroneOptions().origin;
  const double sine = std::sin(origin.latitude * kDegree);
  const double w = std::sqrt(1.0 - kE2 * sine * sine);
  const double meridian = kA * (1.0 - kE2) / (w * w * w), across = kA / w;
  return {(longitude - origin.longitude) * kDegree * (across + altitude) *
              std::cos(origin.latitude * kDegree),
          (latitude - origin.latitude) * kDegree * (meridian + altitude),
          altitude - origin.altitude};
}

class DroneFiles : public TestFolder {
 protected:
  // One flight for all tests.
  static const SimulatedSite& Site() {
    static const SimulatedSite site = Fly();
    return site;
  }
  static SimulatedSite Fly() {
    SimulationOptions options;
    options.seed = 4;
    options.scans = 2;
    options.scanner.beams = 91;
    options.scanner.sweeps = 30;
    options.drone.flight.overlap_along = 0.6;
    options.drone.photogrammetry.pixel_step = 20;
    return Simulate(options);
  }
  DroneFiles() { WriteSite(Path("site"), site_); }
  std::string File(const std::string& name) const { return Path("site/" + name); }

  const SimulatedSite& site_ = Site();
  const SimulatedDrone& drone_ = *site_.drone;
};

TEST_F(DroneFiles, TheCloudReadsBack) {
  const Cloud cloud = ReadCloud(File("uav/cloud.ply"));
  const PhotogrammetryModel& model = drone_.model;
  EXPECT_EQ(cloud.points, model.cloud.points);
  EXPECT_EQ(cloud.normals, model.cloud.normals);
  EXPECT_EQ(cloud.colors, model.cloud.colors);
  EXPECT_EQ(ReadCloud(File("truth/labels/uav_cloud.ply")).points, model.cloud.points);
  const std::string text = ReadTextFile(File("uav/cloud.ply"));
  EXPECT_THAT(text.substr(0, 400), HasSubstr("property float confidence\nproperty float value\n"));
}

TEST_F(DroneFiles, TheSimilarityTakesCloudAndCamerasToTheWorld) {
  const Sim3 world_from_map = ReadSimilarity(File("truth/similarity.json"));
  const Cloud cloud = ReadCloud(File("uav/cloud.ply"));
  std::vector<double> distances;
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    const int label = drone_.model.labels[i];
    if (label == kNotPlanar) continue;
    const Vector3d point = world_from_map * cloud.Position(i);
    distances.push_back(std::abs(site_.planes[label].SignedDistance(point)));
  }
  std::sort(distances.begin(), distances.end());
  EXPECT_LT(distances[distances.size() / 2], 0.1);
  EXPECT_LT(distances[distances.size() * 9 / 10], 0.3);
  // The ground's normal, seen from the model, is up in the world.
  Vector3d up = Vector3d::Zero();
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    up += world_from_map.rotation * cloud.normals[i].cast<double>();
  }
  EXPECT_GT(up.normalized().z(), 0.95);
}

TEST_F(DroneFiles, TheBundleHoldsTheCamerasAsMveWritesThem) {
  const auto lines = Lines(File("uav/synth_0.out"));
  const Sim3 world_from_map = ReadSimilarity(File("truth/similarity.json"));
  const Trajectory truth = ReadTrajectory(File("truth/uav_cameras.tum"));
  ASSERT_EQ(lines.size(), 2 + 5 * truth.size());
  EXPECT_EQ(lines[0], "drews 1.0");
  EXPECT_EQ(Numbers(lines[1]), (std::vector<double>{double(truth.size()), 0.0}));
  std::size_t missing = 0;
  for (std::size_t k = 0; k < truth.size(); ++k) {
    const double focal = Numbers(lines[2 + 5 * k]).at(0);
    Eigen::Matrix<double, 4, 3> rows;
    for (int i = 0; i < 4; ++i) {
      const auto numbers = Numbers(lines[3 + 5 * k + i]);
      ASSERT_EQ(numbers.size(), 3u);
      rows.row(i) = Eigen::Map<const Vector3d>(numbers.data()).transpose();
    }
    if (focal == 0.0) {
      ++missing;
      EXPECT_TRUE(rows.isZero());
      continue;
    }
    EXPECT_NEAR(focal, 0.71875, 1e-9);
    const Eigen::Matrix3d camera_from_map = rows.topRows<3>();
    const Vector3d center =
        world_from_map * (-camera_from_map.transpose() * rows.row(3).transpose());
    EXPECT_LT((center - truth.poses[k].translation).norm(), 0.2) << "errors and the bowl";
    const Eigen::Quaterniond rotation =
        world_from_map.rotation * Eigen::Quaterniond(camera_from_map.transpose().eval());
    EXPECT_LT(AngleBetween(rotation, truth.poses[k].rotation), 0.01);
  }
  EXPECT_LT(missing, truth.size() / 5);
}

TEST_F(DroneFiles, ImagesHaveTheirTimes) {
  const auto lines = Lines(File("uav/images.csv"));
  ASSERT_EQ(lines.size(), 1 + drone_.flight.times.size());
  EXPECT_EQ(lines[0], "time,file");
  EXPECT_EQ(lines[1], "200.000,img_0000.jpg");
  for (std::size_t k = 0; k < drone_.flight.times.size(); ++k) {
    EXPECT_NEAR(std::stod(lines[k + 1]), drone_.flight.times[k], 6e-4);
  }
}

TEST_F(DroneFiles, GpsIsGeodeticAboutTheOrigin) {
  const auto lines = Lines(File("uav/gps.csv"));
  ASSERT_EQ(lines.size(), 1 + drone_.gps.times.size());
  EXPECT_EQ(lines[0], "time,lat,lon,alt");
  for (std::size_t k = 0; k < drone_.gps.times.size(); ++k) {
    const auto fix = Numbers(lines[k + 1]);
    ASSERT_EQ(fix.size(), 4u);
    const Vector3d local = LocalFromGeodetic(fix[1], fix[2], fix[3]);
    EXPECT_LT((local - drone_.gps.positions[k]).norm(), 0.005);
  }
}

TEST_F(DroneFiles, SiteFilesSayWhatIsKnown) {
  const std::string all = ReadTextFile(File("site.yaml"));
  EXPECT_THAT(all, HasSubstr("origin: {lat: 51.488"));
  EXPECT_THAT(all, HasSubstr("start: {translation:"));
  EXPECT_THAT(all, HasSubstr("cameras: uav/synth_0.out"));
  const std::string no_start = ReadTextFile(File("site_nostart.yaml"));
  EXPECT_THAT(no_start, Not(HasSubstr("start:")));
  EXPECT_THAT(no_start, HasSubstr("maps:"));
  const std::string laser_only = ReadTextFile(File("site_laser_only.yaml"));
  EXPECT_THAT(laser_only, Not(HasSubstr("start:")));
  EXPECT_THAT(laser_only, Not(HasSubstr("maps:")));
}

TEST_F(DroneFiles, ASiteWithoutDroneLeavesNoneOfItsSiteFiles) {
  SimulatedSite laser = site_;
  laser.drone.reset();
  WriteSite(Path("site"), laser);
  EXPECT_FALSE(std::filesystem::exists(File("site_nostart.yaml")));
  EXPECT_FALSE(std::filesystem::exists(File("site_laser_only.yaml")));
  EXPECT_THAT(ReadTextFile(File("site.yaml")), Not(HasSubstr("maps:")));
}

TEST(DroneSiteTest, StartsAreTheTruthWithinTheirSigmas) {
  SimulationOptions options;
  options.scene = SceneKind::kQuarter;
  options.scans = 1;
  options.scanner.beams = options.scanner.sweeps = 3;
  options.drone.photogrammetry.pixel_step = 200;
  for (options.seed = 0; options.seed < 5; ++options.seed) {
    for (const SimulatedRobot& robot : Simulate(options).robots) {
      const Vector3d error = robot.start->translation - robot.truth[0].translation;
      EXPECT_LT(error.cwiseAbs().maxCoeff(), 1.0);
      EXPECT_GT(error.norm(), 1e-3);
      const Vector3d ahead = robot.start->rotation * Vector3d::UnitX();
      EXPECT_NEAR(ahead.z(), 0.0, 1e-12) << "level";
      const Vector3d true_ahead = robot.truth[0].rotation * Vector3d::UnitX();
      const double turned =
          std::atan2(ahead.head<2>().x() * true_ahead.y() - ahead.head<2>().y() * true_ahead.x(),
                     ahead.head<2>().dot(true_ahead.head<2>()));
      EXPECT_LT(std::abs(turned), 10.0 * 3.141592653589793 / 180.0);
    }
  }
}

TEST(DroneSiteTest, EqualSeedsGiveEqualFilesForAnyThreads) {
  SimulationOptions options;
  options.scans = 1;
  options.scanner.beams = options.scanner.sweeps = 21;
  options.drone.photogrammetry.pixel_step = 40;
  const auto simulate = [&](std::uint64_t seed, int threads) {
    options.seed = seed;
    options.threads = threads;
    return Simulate(options).drone.value();
  };
  const SimulatedDrone one = simulate(7, 1), three = simulate(7, 3), other = simulate(8, 3);
  EXPECT_TRUE(one.model.cloud.points == three.model.cloud.points);
  EXPECT_TRUE(one.gps.positions == three.gps.positions);
  EXPECT_FALSE(one.model.cloud.points == other.model.cloud.points);
  EXPECT_FALSE(one.gps.positions == other.gps.positions);
}

}  // namespace
}  // namespace planegraph
