// Whole jobs of the built tool on small simulated sites: exit codes, messages, files.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/stat.h>

#include <chrono>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <sstream>
#include <thread>

#include "cli/tool_runner.h"
#include "io/test_files.h"

namespace planegraph::cli {
namespace {

namespace fs = std::filesystem;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Not;
using ::testing::StartsWith;

class Jobs : public TestFolder {
 protected:
  // A simulated site of coarse scans; returns its site file.
  std::string Simulate(const std::string& scene, int scans) {
    const Outcome outcome =
        RunTool("simulate --quiet --scene=" + scene + " --scan_count=" + std::to_string(scans) +
                " --beams=271 --sweeps=90 --output_dir=" + Path(scene));
    EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
    return Path(scene) + "/site.yaml";
  }
  // A site whose scans hold a handful of points: for what fails before it looks at them.
  std::string Tiny(const std::string& more = "") {
    Write("scans/a.xyz", "1 2 3\n4 5 6\n");
    return Write("tiny.yaml", "robots: [{name: a, scans: scans}]\n" + more);
  }
  Outcome Map(const std::string& site, const std::string& flags = "") {
    return RunTool("map " + site + " --output_dir=" + Path("out") + " " + flags);
  }
};

TEST_F(Jobs, MapWritesItsFiles) {
  const std::string site = Simulate("corridor", 8);
  const Outcome outcome = Map(site);
  EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_THAT(outcome.out, HasSubstr("8 scans"));
  EXPECT_THAT(outcome.out, HasSubstr("1 component"));
  EXPECT_THAT(outcome.out, HasSubstr("robot1 against its reference: ATE"));
  EXPECT_THAT(outcome.err, IsEmpty());
  for (const char* name : {"trajectory_robot1.tum", "frames/robot1/scan000.frames",
                           "frames/robot1/scan002.frames", "graph.g2o", "planes/robot1_001.json",
                           "map.ply", "report.json", "report.html", "run.flags"}) {
    EXPECT_TRUE(fs::is_regular_file(Path("out") + "/" + name)) << name;
  }
  // Its own results are what the other commands take.
  const std::string planes = Path("out") + "/planes/robot1_00";
  const Outcome same = RunTool("register --json " + planes + "1.json " + planes + "0.json");
  EXPECT_EQ(same.exit_code, 3) << same.err;  // a corridor looks alike from both of its ends
  EXPECT_NE(nlohmann::json::parse(same.out)["status"], "ok");
  EXPECT_EQ(RunTool("evaluate --quiet --align=first --reference=" + Path("corridor/truth.tum") +
                    " --estimate=" + Path("out/graph.g2o"))
                .exit_code,
            0);
  // A folder of 3DTK poses is a reference and an estimate, pose by pose.
  const std::string folder = Path("out/frames/robot1"), tum = Path("out/trajectory_robot1.tum");
  for (const std::string& files : {"--reference=" + folder + " --estimate=" + tum,
                                   "--reference=" + tum + " --estimate=" + folder}) {
    const auto json = nlohmann::json::parse(RunTool("evaluate --json --align=none " + files).out);
    EXPECT_EQ(json["paired_by"], "index");
    EXPECT_LT(json["ate"]["max"], 1e-9);
    EXPECT_LT(json["rpe"]["rotation"]["max"], 1e-9);
    EXPECT_EQ(json["count"], 8);
  }
  const auto map = nlohmann::json::parse(
      RunTool("evaluate --json --mpv=false --every=50 --map=" + Path("out/map.ply")).out);
  EXPECT_GT(map["planes"]["landmarks"].size(), 3u);
  EXPECT_LT(map["planes"]["laser_on_laser"]["rms"], 0.05);
}

TEST_F(Jobs, MapAsJsonIsTheReport) {
  const Outcome outcome = Map(Simulate("hall", 2), "--json --optimizer=none");
  const auto printed = nlohmann::json::parse(outcome.out);
  EXPECT_EQ(printed, nlohmann::json::parse(ReadTextFile(Path("out/report.json"))));
  EXPECT_EQ(printed["solve"]["optimizer"], "none");
  EXPECT_EQ(printed["scans"].size(), 2u);
}

TEST_F(Jobs, QuietMapSaysNothing) {
  const Outcome outcome = Map(Simulate("corridor", 8), "--quiet --optimizer=none");
  EXPECT_EQ(outcome.exit_code, 0);
  EXPECT_THAT(outcome.out, IsEmpty());
  EXPECT_THAT(outcome.err, IsEmpty());
}

TEST_F(Jobs, AnOutputFolderThatCannotBeMadeIsBadInput) {
  const Outcome outcome = RunTool("map " + Tiny() + " --output_dir=/proc/nowhere");
  EXPECT_EQ(outcome.exit_code, 2);
  EXPECT_THAT(outcome.err, StartsWith("error: /proc/nowhere"));
}

TEST_F(Jobs, ASiteFilesErrorNamesItsLine) {
  const std::string site = Write("bad.yaml", "name: a\nrobot: []\n");
  const Outcome outcome = Map(site);
  EXPECT_EQ(outcome.exit_code, 2);
  EXPECT_THAT(outcome.err, StartsWith("error: " + site + ":2: unknown key 'robot'"));
  EXPECT_FALSE(fs::exists(Path("out")));
}

TEST_F(Jobs, ACloudIsNoSiteFile) {
  for (const std::string& start : {std::string("ply\nformat ascii 1.0\n"),
                                   std::string("# .PCD v0.7\n"), std::string("\1\0\2", 3)}) {
    const std::string cloud = Write("cloud.bin", start);
    const Outcome outcome = Map(cloud);
    EXPECT_EQ(outcome.exit_code, 2);
    EXPECT_EQ(outcome.err, "error: " + cloud + ": is a cloud, not a site file\n");
  }
}

TEST_F(Jobs, AMissingArgumentShowsTheUsage) {
  const Outcome outcome = RunTool("map --output_dir=" + Path("out"));
  EXPECT_EQ(outcome.exit_code, 1);
  EXPECT_EQ(outcome.err, "error: an argument is missing: planegraph map [--flags] SITE.yaml\n");
}

TEST_F(Jobs, NumbersOfFlagsAreShort) {
  EXPECT_THAT(RunTool("map --help").out, HasSubstr("[0.05]"));
  Map(Tiny(), "--map_voxel=0.1");
  EXPECT_THAT(ReadTextFile(Path("out/run.flags")), HasSubstr("--map_voxel=0.1\n"));
  Map(Tiny(), "--map_voxel=30");  // neither 30.000000000000000 nor 3e+01
  EXPECT_THAT(ReadTextFile(Path("out/run.flags")), HasSubstr("--map_voxel=30\n"));
}

TEST_F(Jobs, AScanThatCannotBeReadIsNamed) {
  const std::string site = Tiny();
  const std::string scan = Write("scans/a.xyz", "1 2 3\n4 five 6\n");
  const Outcome outcome = Map(site);
  EXPECT_EQ(outcome.exit_code, 2);
  EXPECT_THAT(outcome.err, StartsWith("error: " + scan + ":2:"));
  EXPECT_FALSE(fs::exists(Path("out/report.json")));
}

TEST_F(Jobs, UnknownNamesAreWrongUsage) {
  for (const char* flags :
       {"--optimizer=simplex", "--loss=parabola", "--loss=huber:-1", "--loss=huber,gps=dcs",
        "--plane_factor=none_such", "--plane_factor=relative_pose"}) {
    const Outcome outcome = Map(Tiny(), flags);
    EXPECT_EQ(outcome.exit_code, 1) << flags;
    EXPECT_THAT(outcome.err, StartsWith("error: ")) << flags;
    EXPECT_THAT(outcome.out, IsEmpty()) << flags;
  }
}

TEST_F(Jobs, AnUnknownLossListsTheLosses) {
  const Outcome outcome = RunTool("map site.yaml --output_dir=" + Path("out") + " --loss=huberr");
  EXPECT_EQ(outcome.exit_code, 1);
  EXPECT_THAT(outcome.err, testing::HasSubstr("soft_l1, cauchy"));
}

TEST_F(Jobs, ALossForAnUnknownFactorListsTheFactors) {
  const Outcome outcome = Map(Tiny(), "--loss=cauchy:1,gps=tukey:3");
  EXPECT_EQ(outcome.exit_code, 1);
  EXPECT_THAT(outcome.err, ::testing::HasSubstr("unknown factor 'gps'"));
  EXPECT_THAT(outcome.err, ::testing::HasSubstr("robot_position"));
}

TEST_F(Jobs, LossesOfFactorsAreInTheReport) {
  ASSERT_EQ(Map(Tiny(), "--loss=huber,relative_pose=dcs:2").exit_code, 0);
  std::ifstream file(Path("out/report.json"));
  const auto report = nlohmann::json::parse(file);
  EXPECT_EQ(report["solve"]["loss"], "huber,relative_pose=dcs:2");
  EXPECT_TRUE(report["switched_off"].is_array());
}

TEST_F(Jobs, ScansThatDoNotFitTogetherAreNoFullResult) {
  const std::string site = Simulate("corridor", 2);
  Simulate("yard", 1);
  fs::copy_file(Path("yard/scans/scan000.ply"), Path("corridor/scans/scan001.ply"),
                fs::copy_options::overwrite_existing);
  const Outcome outcome = Map(site);
  EXPECT_EQ(outcome.exit_code, 3);
  EXPECT_THAT(outcome.err, HasSubstr("do not form one component but 2: robot1/001 stands apart; " +
                                     Path("out") + "/report.html says why"));
  EXPECT_THAT(outcome.out, HasSubstr("2 scans, 0 of 1 registration between scans used, 2 comp"));
  EXPECT_THAT(outcome.out, HasSubstr("no registration joins 2 scans, each by itself: nothing"));
  EXPECT_EQ(nlohmann::json::parse(ReadTextFile(Path("out/report.json")))["components"], 2);
}

TEST_F(Jobs, ADroneMapThatNoScanIsFoundInIsNoFullResult) {
  const std::string site = Simulate("corridor", 2);
  std::ofstream(site, std::ios::app) << "maps: [{name: roof, cloud: roof.ply}]\n";
  std::string roof =
      "ply\nformat ascii 1.0\nelement vertex 10000\nproperty float x\n"
      "property float y\nproperty float z\nend_header\n";
  for (int i = 0; i < 10000; ++i) {
    roof += std::to_string(0.1 * (i % 100)) + " " + std::to_string(0.1 * (i / 100)) + " 0\n";
  }
  Write("corridor/roof.ply", roof);
  const Outcome outcome = Map(site);
  EXPECT_EQ(outcome.exit_code, 3);
  EXPECT_THAT(outcome.err, testing::HasSubstr("no scan was found in the drone map roof: "));
  EXPECT_TRUE(fs::exists(Path("out/trajectory_robot1.tum")));
}

TEST_F(Jobs, AReferenceThatDoesNotFitIsAWarning) {
  const std::string site = Simulate("corridor", 8);
  Write("corridor/truth.tum", "9000 0 0 0 0 0 0 1\n9001 0 0 0 0 0 0 1\n");
  const Outcome outcome = Map(site);
  EXPECT_EQ(outcome.exit_code, 0);
  EXPECT_THAT(outcome.err, StartsWith("warning: no evaluation of robot1"));
}

TEST_F(Jobs, UnrelatedCloudsDoNotRegister) {
  Simulate("hall", 1);
  Simulate("corridor", 1);
  const Outcome outcome = RunTool("register --json " + Path("hall/scans/scan000.ply") + " " +
                                  Path("corridor/scans/scan000.ply"));
  EXPECT_EQ(outcome.exit_code, 3);
  const auto result = nlohmann::json::parse(outcome.out);
  EXPECT_NE(result["status"], "ok");
  EXPECT_NE(result["reason"], "");
}

TEST_F(Jobs, ACloudRegistersToItself) {
  Simulate("hall", 1);
  const std::string scan = Path("hall/scans/scan000.ply");
  const Outcome outcome = RunTool("register --json " + scan + " " + scan);
  EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
  const auto result = nlohmann::json::parse(outcome.out);
  EXPECT_EQ(result["status"], "ok");
  for (const double t : result["target_from_source"]["translation"]) EXPECT_NEAR(t, 0.0, 1e-3);
}

TEST_F(Jobs, SegmentWithoutAPlaneIsNoResult) {
  std::string points;
  for (int i = 0; i < 20; ++i)
    points += std::to_string(7 * i % 11) + " " + std::to_string(5 * i % 13) + " 3\n";
  const Outcome outcome =
      RunTool("segment " + Write("few.xyz", points) + " --output=" + Path("planes.json"));
  EXPECT_EQ(outcome.exit_code, 3);
  const auto planes = nlohmann::json::parse(ReadTextFile(Path("planes.json")));
  EXPECT_THAT(planes["planes"], IsEmpty());
  EXPECT_NE(planes["reason"], "");
}

TEST_F(Jobs, SegmentAsksForTheUnit) {
  // A line of points that goes so many units far.
  const auto outcome = [&](int far) {
    std::ostringstream points;
    for (int k = 1; k <= 200; ++k) points << 0.005 * k * far << " 0 0\n";
    return RunTool("segment " + Write("line.xyz", points.str()) + " --output=" + Path("p.json"));
  };
  const Outcome metres = outcome(30), millimetres = outcome(30000);
  EXPECT_EQ(metres.exit_code, 3) << metres.err;
  EXPECT_THAT(metres.err, Not(HasSubstr("metres?")));
  EXPECT_EQ(millimetres.exit_code, 3) << millimetres.err;
  EXPECT_THAT(millimetres.err, HasSubstr("farther than 100 m: are the units metres?"));
}

// A pipe that gives nothing for long: whoever waits for the command sees that it lives.
TEST_F(Jobs, LongWorkShowsThatItLives) {
  const std::string pipe = Path("slow.xyz");
  ASSERT_EQ(::mkfifo(pipe.c_str(), 0600), 0);
  std::thread writer([&] {
    std::ofstream stream(pipe);
    std::this_thread::sleep_for(std::chrono::seconds(14));
    stream << "1 2 3\n";
  });
  const Outcome outcome = RunTool("convert " + pipe + " " + Path("out.ply"));
  writer.join();
  EXPECT_EQ(outcome.exit_code, 0);
  EXPECT_THAT(outcome.err, StartsWith("planegraph convert: at work, 1"));
}

// Two walls and a ground, so large that somebody may have meant millimetres.
TEST_F(Jobs, RegisterAsksForTheUnit) {
  const auto outcome = [&](double size) {
    std::ostringstream points;
    for (int i = 0; i < 40; ++i) {
      for (int k = 0; k < 40; ++k) {
        const double a = size * (i - 20), b = size * (k - 20), c = size * k;
        points << a << " " << b << " " << -2 * size << "\n"
               << a << " " << 20 * size << " " << c << "\n"
               << 20 * size << " " << b << " " << c << "\n";
      }
    }
    const std::string cloud = Write("corner.xyz", points.str());
    return RunTool("register " + cloud + " " + cloud + " --noise=0.01");
  };
  EXPECT_THAT(outcome(0.2).err, Not(HasSubstr("metres?")));
  EXPECT_THAT(outcome(200.0).err,
              HasSubstr("corner.xyz: half of the points are farther than 100 m: are the units"));
}

TEST_F(Jobs, SegmentOfAnEmptyFileIsBadInput) {
  const std::string cloud = Write("empty.ply", "");
  const Outcome outcome = RunTool("segment " + cloud + " --output=" + Path("planes.json"));
  EXPECT_EQ(outcome.exit_code, 2);
  EXPECT_THAT(outcome.err, StartsWith("error: " + cloud + ":"));
  EXPECT_FALSE(fs::exists(Path("planes.json")));
}

TEST_F(Jobs, AnOutputThatCannotBeWrittenIsBadInput) {
  Simulate("corridor", 1);
  const Outcome outcome = RunTool("segment " + Path("corridor/scans/scan000.ply") +
                                  " --output=/proc/nowhere/planes.json");
  EXPECT_EQ(outcome.exit_code, 2);
  EXPECT_THAT(outcome.err, HasSubstr("/proc/nowhere/planes.json"));
}

}  // namespace
}  // namespace planegraph::cli
