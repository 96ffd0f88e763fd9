#include "planegraph/pipeline/site.h"

#include <gmock/gmock.h>

#include <filesystem>
#include <numbers>

#include "io/test_files.h"
#include "planegraph/io/trajectory_io.h"

namespace planegraph {
namespace {

using ::testing::ElementsAre;
using ::testing::EndsWith;
using ::testing::HasSubstr;

constexpr char kPose[] = "0 0 0 0 0 0 0 1\n";

class SiteFile : public TestFolder {
 protected:
  SiteFile() {
    for (const char* scan : {"scans/b.xyz", "scans/a.xyz", "scans/c.xyz"}) Write(scan, "1 2 3\n");
  }

  // The complaint about a site file with this text: of that line of it, and with these words.
  void ExpectError(const std::string& text, const std::string& place, const std::string& words) {
    SCOPED_TRACE(text);
    const std::string path = Write("site.yaml", text);
    try {
      ReadSite(path);
      FAIL() << "no error";
    } catch (const InputError& error) {
      EXPECT_EQ(error.file(), path);
      EXPECT_EQ(error.place(), place);
      EXPECT_THAT(error.reason(), HasSubstr(words));
    }
  }
};

TEST_F(SiteFile, ReadsEveryKey) {
  Write("odometry.tum", "1.5 0 0 0 0 0 0 1\n2.5 1 0 0 0 0 0 1\n3.5 2 0 0 0 0 0 1\n");
  Write("truth.tum", kPose);
  const Site site = ReadSite(Write("site.yaml", R"(name: barn
robots:
  - name: ugv
    scans: scans/*.xyz
    format: xyz
    odometry: odometry.tum
    start: {translation: [1, 2, 3], rotation: [0, 0, 1, 0], sigma_translation: 0.5, sigma_rotation_deg: 18}
    reference: truth.tum
    filters: [{range: {min: 1, max: 20}}, {voxel: {size: 0.1}}]
)"));
  EXPECT_EQ(site.name, "barn");
  ASSERT_EQ(site.robots.size(), 1u);
  const RobotSite& robot = site.robots[0];
  EXPECT_EQ(robot.name, "ugv");
  EXPECT_EQ(robot.format, "xyz");
  EXPECT_THAT(robot.scans, ElementsAre(EndsWith("a.xyz"), EndsWith("b.xyz"), EndsWith("c.xyz")));
  ASSERT_TRUE(robot.odometry.has_value());
  EXPECT_THAT(robot.odometry->times, ElementsAre(1.5, 2.5, 3.5));
  ASSERT_TRUE(robot.start.has_value());
  EXPECT_EQ(robot.start->world_from_scan.translation, Eigen::Vector3d(1, 2, 3));
  EXPECT_EQ(robot.start->world_from_scan.rotation.z(), 1.0);
  EXPECT_EQ(robot.start->sigma_translation, 0.5);
  EXPECT_NEAR(robot.start->sigma_rotation, std::numbers::pi / 10, 1e-15);
  EXPECT_THAT(robot.reference, EndsWith("truth.tum"));
  ASSERT_EQ(robot.filters.size(), 2u);
  EXPECT_EQ(robot.filters[0].name, "range");
  EXPECT_EQ(robot.filters[0].parameters.at("max"), 20.0);
  EXPECT_EQ(robot.filters[1].parameters.at("size"), 0.1);
}

TEST_F(SiteFile, ReadsTheOriginAndWhatIsKnownOfAMap) {
  Write("uav/cloud.ply", "");
  const Site site = ReadSite(Write("site.yaml", R"(origin: {lat: 51.5, lon: -7.5, alt: 115}
robots: [{name: a, scans: scans}]
maps:
  - {name: m, cloud: uav/cloud.ply, scale: 8.5, scale_sigma: 0.01, gps_sigma: 1.5}
  - {name: n, cloud: uav/cloud.ply}
)"));
  ASSERT_TRUE(site.origin.has_value());
  EXPECT_EQ(site.origin->latitude, 51.5);
  EXPECT_EQ(site.origin->longitude, -7.5);
  EXPECT_EQ(site.origin->altitude, 115.0);
  EXPECT_EQ(site.maps[0].scale, 8.5);
  EXPECT_FALSE(site.maps[1].scale.has_value());
  EXPECT_EQ(site.maps[0].scale_sigma, 0.01);
  EXPECT_EQ(site.maps[0].gps_sigma, 1.5);
  EXPECT_FALSE(site.maps[1].scale_sigma.has_value());
  EXPECT_EQ(site.maps[1].reference, "");
  EXPECT_FALSE(ReadSite(Write("b.yaml", "robots: [{name: a, scans: scans}]")).origin.has_value());
}

TEST_F(SiteFile, ReadsTheTilesOfABentMap) {
  Write("uav/cloud.ply", "");
  const std::string map =
      "robots: [{name: a, scans: scans}]\nmaps:\n  - name: m\n    cloud: uav/cloud.ply\n    ";
  const Site site = ReadSite(Write(
      "site.yaml", map + "tiles: {size: 12.5, sigma_rotation_deg: 18, sigma_translation: 0.1}\n"));
  ASSERT_TRUE(site.maps[0].tiles.has_value());
  EXPECT_EQ(site.maps[0].tiles->size, 12.5);
  EXPECT_NEAR(site.maps[0].tiles->sigma_rotation, std::numbers::pi / 10, 1e-15);
  EXPECT_EQ(site.maps[0].tiles->sigma_translation, 0.1);
  EXPECT_EQ(site.maps[0].tiles->sigma_scale, MapTiling().sigma_scale);
  EXPECT_FALSE(ReadSite(Write("b.yaml", map)).maps[0].tiles.has_value());
  EXPECT_EQ(ReadSite(Write("c.yaml", map + "tiles: {}\n")).maps[0].tiles->size, MapTiling().size);
  ExpectError(map + "tiles: 30\n", "5", "by name");
  ExpectError(map + "tiles: {size: 0}\n", "5", "positive");
  ExpectError(map + "tiles: {size: 0.5}\n", "5", "at least 1 m");
  ExpectError(map + "tiles: {sigma_scale: -1}\n", "5", "positive");
  ExpectError(map + "tiles: {edge: 30}\n", "5", "'edge'");
}

TEST_F(SiteFile, ReadsWhatAnOdometryErrsBy) {
  const std::string robot = "robots:\n  - name: a\n    scans: scans\n    ";
  const OdometryNoise usual;
  const OdometryNoise noise =
      ReadSite(Write("site.yaml", robot + "odometry_noise: {step: 0.5, scale: 0, per_turn: 0.2, "
                                          "step_deg: 18}\n"))
          .robots[0]
          .odometry_noise;
  EXPECT_EQ(noise.step, 0.5);
  EXPECT_EQ(noise.scale, 0.0);
  EXPECT_EQ(noise.per_turn, 0.2);
  EXPECT_NEAR(noise.step_rotation, std::numbers::pi / 10, 1e-15);
  EXPECT_EQ(noise.per_metre, usual.per_metre);
  EXPECT_EQ(noise.rotation_per_metre, usual.rotation_per_metre);
  ExpectError(robot + "odometry_noise: {step: 0}\n", "4", "step must be positive");
  ExpectError(robot + "odometry_noise: {scale: -0.1}\n", "4", "scale must be");
  ExpectError(robot + "odometry_noise: {per_metre: .inf}\n", "4", "per_metre must be");
  ExpectError(robot + "odometry_noise: {metres: 1}\n", "4", "'metres'");
}

TEST_F(SiteFile, ReadsReceiversAndGravity) {
  Write("odometry.tum", "1.5 0 0 0 0 0 0 1\n2.5 1 0 0 0 0 0 1\n3.5 2 0 0 0 0 0 1\n");
  Write("gps.csv", "time,lat,lon,alt\n1,51.5,7.5,100\n4,51.5,7.5,100\n");
  Write("uav/cloud.ply", "");
  const std::string robot =
      "robots:\n  - name: a\n    scans: scans\n    odometry: odometry.tum\n    ";
  const Site site = ReadSite(Write("site.yaml", robot + R"(gps: gps.csv
    gps_lever: [0.1, -0.2, 0.5]
    gps_sigma: 0.3
    gravity: {up: [0, 0, 2], sigma_deg: 18}
maps: [{name: m, cloud: uav/cloud.ply, gravity: {up: [0, 1, 0]}}]
)"));
  ASSERT_TRUE(site.robots[0].gps.has_value());
  EXPECT_THAT(site.robots[0].gps->file, EndsWith("gps.csv"));
  EXPECT_EQ(site.robots[0].gps->lever, Eigen::Vector3d(0.1, -0.2, 0.5));
  EXPECT_EQ(site.robots[0].gps->sigma, 0.3);
  ASSERT_TRUE(site.robots[0].gravity.has_value());
  EXPECT_EQ(site.robots[0].gravity->up, Eigen::Vector3d::UnitZ());
  EXPECT_NEAR(site.robots[0].gravity->sigma, std::numbers::pi / 10, 1e-15);
  ASSERT_TRUE(site.maps[0].gravity.has_value());
  EXPECT_EQ(site.maps[0].gravity->up, Eigen::Vector3d::UnitY());
  ExpectError(robot + "gps: nowhere.csv\n", "5", "nowhere.csv");
  ExpectError(robot + "gps: gps.csv\n    gps_lever: [1, 2]\n", "6", "3 numbers");
  ExpectError(robot + "gps: gps.csv\n    gps_sigma: 0\n", "6", "positive");
  ExpectError(robot + "gravity: {up: [0, 0, 0]}\n", "5", "no direction");
  ExpectError(robot + "gravity: {down: [0, 0, 0]}\n", "5", "'down'");
  ExpectError("robots:\n  - name: a\n    scans: scans\n    gps: gps.csv\n", "4", "time stamps");
}

TEST_F(SiteFile, OriginsAndSigmasThatMakeNoSense) {
  const std::string robots = "robots: [{name: a, scans: scans}]\n";
  ExpectError(robots + "origin: {lat: 51, lon: 7}\n", "2", "`alt`");
  ExpectError(robots + "origin: {lat: 91, lon: 7, alt: 0}\n", "2", "on earth");
  ExpectError(robots + "origin: {lat: .nan, lon: 7, alt: 0}\n", "2", "on earth");
  ExpectError(robots + "origin: {lat: far, lon: 7, alt: 0}\n", "2", "lat");
  ExpectError(robots + "origin: [51, 7, 0]\n", "2", "entries");
  ExpectError(robots + "origin: {lat: 1, lon: 7, alt: 0, z: 1}\n", "2", "'z'");
  const std::string map = robots + "maps:\n  - name: m\n    cloud: scans/a.xyz\n    ";
  ExpectError(map + "scale_sigma: 0\n", "5", "positive");
  ExpectError(map + "gps_sigma: -1\n", "5", "positive");
  ExpectError(map + "gps_sigma: .inf\n", "5", "positive");
}

TEST_F(SiteFile, TheTrueScaleOfAMapIsCheckedBeforeTheRun) {
  Write("uav/cloud.ply", "");
  const std::string map =
      "robots: [{name: a, scans: scans}]\nmaps: [{name: m, cloud: uav/cloud.ply, reference: "
      "t.json}]";
  for (const char* bad : {"scale", "[1]", "{\"scale\": 0}", "{\"scale\": \"2\"}", "{}"}) {
    Write("t.json", bad);
    EXPECT_THROW(ReadSite(Write("site.yaml", map)), InputError) << bad;
  }
  const std::string truth = Write("t.json", "{\"scale\": 2.5}");
  EXPECT_EQ(ReadSite(Write("site.yaml", map)).maps[0].reference, truth);
}

TEST_F(SiteFile, TheNameIsTheFilesWithoutOne) {
  EXPECT_EQ(ReadSite(Write("barn.yaml", "robots: [{name: a, scans: scans}]")).name, "barn");
}

TEST_F(SiteFile, AFolderIsReadInOrderOfNames) {
  Write("scans/notes.md", "no scan");
  const Site site = ReadSite(Write("site.yaml", "robots: [{name: a, scans: scans}]"));
  EXPECT_THAT(site.robots[0].scans,
              ElementsAre(EndsWith("a.xyz"), EndsWith("b.xyz"), EndsWith("c.xyz")));
}

TEST_F(SiteFile, AFolderHoldsScansOfEveryFormatThatIsRead) {
  for (const char* scan : {"all/1.asc", "all/2.pts", "all/3.csv", "all/4.PLY"}) Write(scan, "");
  Write("all/5.las", "");
  const Site site = ReadSite(Write("site.yaml", "robots: [{name: a, scans: all}]"));
  EXPECT_THAT(site.robots[0].scans, ElementsAre(EndsWith("1.asc"), EndsWith("2.pts"),
                                                EndsWith("3.csv"), EndsWith("4.PLY")));
}

TEST_F(SiteFile, AFolderWithoutScansSaysWhatTheyAre) {
  Write("las/a.las", "");
  ExpectError("robots:\n  - name: a\n    scans: las\n", "3", ".asc .pts .3d); export .las");
}

TEST_F(SiteFile, FiltersTakeThePlaceOfTheDefault) {
  const std::string robot = "robots:\n  - name: a\n    scans: scans\n";
  const Site by_default = ReadSite(Write("site.yaml", robot));
  ASSERT_EQ(by_default.robots[0].filters.size(), 1u);
  EXPECT_EQ(by_default.robots[0].filters[0].parameters.at("min"), 0.5);
  EXPECT_TRUE(ReadSite(Write("site.yaml", robot + "    filters: []\n")).robots[0].filters.empty());
}

TEST_F(SiteFile, AFolderIsNoSite) {
  try {
    ReadSite(Path("scans"));
    FAIL();
  } catch (const InputError& error) {
    EXPECT_THAT(error.reason(), HasSubstr("takes a site file"));
  }
}

TEST_F(SiteFile, PosesBesideScansAreTheOdometry) {
  for (int i = 0; i < 3; ++i) {
    const std::string name = "dtk/scan00" + std::to_string(i);
    Write(name + ".3d", "100 0 0\n");
    Write3dtkPose(Path(name + ".pose"), {Eigen::Quaterniond::Identity(), {0.5 * i, 0, 0}});
  }
  const Site site = ReadSite(Write("site.yaml", "robots: [{name: a, scans: dtk, format: 3dtk}]"));
  ASSERT_TRUE(site.robots[0].odometry.has_value());
  EXPECT_FALSE(site.robots[0].odometry->has_times);
  EXPECT_NEAR(site.robots[0].odometry->poses[2].translation.x(), 1.0, 1e-12);
}

TEST_F(SiteFile, AMissingFileIsNamed) {
  try {
    ReadSite(Path("none.yaml"));
    FAIL();
  } catch (const InputError& error) {
    EXPECT_EQ(error.file(), Path("none.yaml"));
  }
}

TEST_F(SiteFile, WhatIsNoSite) {
  ExpectError("robots: [\n", "2", "YAML");
  ExpectError("name: a\n\tb: c\n", "2", "YAML");
  ExpectError("just words\n", "1", "not a site");
  ExpectError("", "1", "not a site");
  ExpectError("name: a\n", "1", "robots");
  ExpectError("name: a\nrobots: []\n", "1", "robots");
  ExpectError("name: [a, b]\nrobots: []\n", "1", "name");
  ExpectError("robots:\n  - just words\n", "2", "key");
  ExpectError("name: a\nrobots:\n  name: b\n  scans: scans\n", "3", "begins with `- name:`");
}

TEST_F(SiteFile, UnknownKeysAreNamedWithTheirLine) {
  ExpectError("robots:\n  - name: a\n    scans: scans\nspeed: 3\n", "4", "'speed'");
  ExpectError("robots:\n  - name: a\n    scan: scans\n", "3", "'scan'");
  ExpectError("robots:\n  - name: a\n    scan: scans\n", "3", "did you mean scans?");
  ExpectError("robots:\n  - name: a\n    scans: scans\n    start: {yaw: 3}\n", "4", "'yaw'");
  ExpectError("robots:\n  - {name: a, scans: scans}\nmaps:\n  - name: m\n    points: p\n", "5",
              "'points'");
}

TEST_F(SiteFile, RobotsNeedNamesOfTheirOwnAndScans) {
  ExpectError("robots:\n  - scans: scans\n", "2", "name");
  ExpectError("robots:\n  - name: a/b\n    scans: scans\n", "2", "slash");
  ExpectError("robots:\n  - name: a\n", "2", "scans");
  ExpectError("robots:\n  - {name: a, scans: scans}\n  - {name: a, scans: scans}\n", "3", "taken");
}

TEST_F(SiteFile, FilesThatAreNotThere) {
  ExpectError("robots:\n  - name: a\n    scans: scans/*.ply\n", "3", "no scan");
  ExpectError("robots:\n  - name: a\n    scans: nowhere\n", "3", "no scan");
  ExpectError("robots:\n  - name: a\n    scans: scans\n    odometry: o.tum\n", "4", "odometry");
  ExpectError("robots:\n  - name: a\n    scans: scans\n    reference: r.tum\n", "4", "reference");
  ExpectError("robots:\n  - {name: a, scans: scans}\nmaps:\n  - name: m\n    cloud: m.ply\n", "5",
              "cloud");
}

TEST_F(SiteFile, ABadReferenceShowsBeforeTheRun) {
  const std::string bad = Write("truth.tum", "0 0 0 0 0 0 0 1\n1 x 0 0 0 0 0 1\n");
  try {
    ReadSite(Write("site.yaml", "robots: [{name: a, scans: scans, reference: truth.tum}]"));
    FAIL();
  } catch (const InputError& error) {
    EXPECT_EQ(error.file(), bad);
    EXPECT_EQ(error.place(), "2");
  }
}

TEST_F(SiteFile, OdometryOfAnotherLength) {
  Write("odometry.tum", kPose);
  ExpectError("robots:\n  - name: a\n    scans: scans\n    odometry: odometry.tum\n", "4",
              "1 poses, but there are 3 scans");
}

TEST_F(SiteFile, StartsThatMakeNoSense) {
  const auto start = [](const std::string& text) {
    return "robots:\n  - name: a\n    scans: scans\n    start: {" + text + "}\n";
  };
  ExpectError(start("rotation: [0, 0, 0, 2]"), "4", "unit");
  ExpectError(start("rotation: [0, 0, 0, 0]"), "4", "unit");
  ExpectError(start("rotation: [0, 0, .nan, 1]"), "4", "rotation");
  ExpectError(start("rotation: [0, 0, 1]"), "4", "4 numbers");
  ExpectError(start("translation: [0, 0]"), "4", "3 numbers");
  ExpectError(start("translation: [0, .inf, 0]"), "4", "translation");
  ExpectError(start("translation: far"), "4", "translation");
  ExpectError(start("sigma_translation: 0"), "4", "positive");
  ExpectError(start("sigma_rotation_deg: -3"), "4", "positive");
  ExpectError(start("sigma_rotation_deg: .nan"), "4", "positive");
}

TEST_F(SiteFile, FiltersThatMakeNoSense) {
  const auto filters = [](const std::string& text) {
    return "robots:\n  - name: a\n    scans: scans\n    filters: " + text + "\n";
  };
  ExpectError(filters("{range: {min: 1}}"), "4", "list");
  ExpectError(filters("[range]"), "4", "parameters");
  ExpectError(filters("[{range: 5}]"), "4", "range");
  ExpectError(filters("[{range: {min: near}}]"), "4", "range.min");
  ExpectError(filters("[{smooth: {}}]"), "4", "smooth");
  ExpectError(filters("[{range: {least: 1}}]"), "4", "least");
  ExpectError(filters("[{voxel: {size: -1}}]"), "4", "size");
}

TEST_F(SiteFile, AnUnknownFormat) {
  ExpectError("robots:\n  - name: a\n    scans: scans\n    format: las\n", "4", "las");
}

TEST_F(SiteFile, MapsAreAList) {
  ExpectError("robots:\n  - {name: a, scans: scans}\nmaps:\n  name: m\n", "4", "maps");
  ExpectError("robots:\n  - {name: a, scans: scans}\nmaps: 3\n", "3", "maps");
  ExpectError("robots:\n  - {name: a, scans: scans}\nmaps:\n  - cloud: scans/a.xyz\n", "4", "name");
  ExpectError("robots:\n  - {name: a, scans: scans}\nmaps:\n  - name: m\n", "4", "cloud");
}

}  // namespace
}  // namespace planegraph
