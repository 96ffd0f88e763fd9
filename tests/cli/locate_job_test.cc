// `planegraph locate` as a whole: result, exit codes, messages.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <nlohmann/json.hpp>
#include <sstream>

#include "cli/tool_runner.h"
#include "io/test_files.h"

namespace planegraph::cli {
namespace {

using Json = nlohmann::json;
using ::testing::HasSubstr;

class LocateJob : public TestFolder {
 protected:
  LocateJob() {
    const Outcome made =
        RunTool("simulate --quiet --scene=yard --seed=3 --scan_count=4 " +
                std::string("--beams=361 --sweeps=120 --output_dir=") + Path("yard"));
    EXPECT_EQ(made.exit_code, 0) << made.err;
  }
  std::string Scan(int k) const { return Path("yard/scans/scan00" + std::to_string(k) + ".ply"); }
  std::string Map() const { return " --map=" + Path("yard/uav/cloud.ply"); }
  std::string Gps() const {
    return " --cameras=" + Path("yard/uav/synth_0.out") + " --gps=" + Path("yard/uav/gps.csv") +
           " --image_times=" + Path("yard/uav/images.csv");
  }
  Json Truth() const { return Json::parse(ReadTextFile(Path("yard/truth/similarity.json"))); }

  // Distance of the place that was found from the scan's true one, metres.
  double Error(const Json& found, int scan) const {
    const Json truth = Truth();
    std::istringstream lines(ReadTextFile(Path("yard/truth.tum")));
    std::string line;
    for (int k = 0; k <= scan; ++k) std::getline(lines, line);
    double time = 0.0, position[3] = {}, square = 0.0;
    std::istringstream(line) >> time >> position[0] >> position[1] >> position[2];
    const Json& in_map = found["candidates"][0]["map_from_scan"]["translation"];
    for (int a = 0; a < 3; ++a) {
      double at = truth["t"][a].get<double>();
      for (int b = 0; b < 3; ++b) {
        at +=
            truth["scale"].get<double>() * truth["R"][a][b].get<double>() * in_map[b].get<double>();
      }
      square += (at - position[a]) * (at - position[a]);
    }
    return std::sqrt(square);
  }
};

TEST_F(LocateJob, FindsAScanInAMapBeyondItsMemory) {
  for (const char* memory : {"20", "5"}) {
    const Outcome tiles = RunTool("locate --json --threads=2 " + Scan(0) + Map() + Gps() +
                                  " --map_memory=" + memory + " --scratch_dir=" + Path(""));
    ASSERT_EQ(tiles.exit_code, 0) << tiles.err;
    EXPECT_LT(Error(Json::parse(tiles.out), 0), 0.2) << memory;
  }
}

TEST_F(LocateJob, SaysWhatIsWrongWithTheScratchFolderAndTheMap) {
  const std::string job = "locate --map_memory=1 " + Scan(0) + Gps();
  const Outcome nowhere = RunTool(job + Map() + " --scratch_dir=" + Path("nowhere"));
  EXPECT_EQ(nowhere.exit_code, 2);
  EXPECT_THAT(nowhere.err, HasSubstr("takes no scratch file of a large drone map"));
  const std::string bytes = ReadTextFile(Path("yard/uav/cloud.ply"));
  const std::string cut = Write("cut.ply", bytes.substr(0, bytes.size() / 2));
  const Outcome damaged = RunTool(job + " --map=" + cut);
  EXPECT_EQ(damaged.exit_code, 2);
  EXPECT_THAT(damaged.err, HasSubstr("the file ends"));
  EXPECT_EQ(RunTool("locate --map_memory=0 " + Scan(0) + Map()).exit_code, 1);
}

TEST_F(LocateJob, FindsAScanByGpsScaleAndByAStatedOne) {
  char scale[64];
  std::snprintf(scale, sizeof(scale), " --map_scale=%.6f", Truth()["scale"].get<double>());
  for (const std::string& how : {Gps(), std::string(scale)}) {
    const Outcome outcome = RunTool("locate --json " + Scan(0) + Map() + how);
    ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
    const Json found = Json::parse(outcome.out);
    EXPECT_EQ(found["status"], "ok");
    EXPECT_EQ(found["reason"], "");
    EXPECT_LT(Error(found, 0), 0.2);
    const double unit = found["candidates"][0]["map_from_scan"]["scale"].get<double>();
    EXPECT_NEAR(unit * Truth()["scale"].get<double>(), 1.0, 0.01);
    const Json& slid = found["slid"];
    EXPECT_GT(slid["metres"].get<double>(), 0.0);
    EXPECT_LE(slid["probability"].get<double>(), found["chance"].get<double>());
    double square = 0.0;
    for (const Json& d : slid["direction"]) square += d.get<double>() * d.get<double>();
    EXPECT_NEAR(square, 1.0, 1e-9);
  }
}

TEST_F(LocateJob, AScanOfAnotherPlaceIsNoResult) {
  ASSERT_EQ(RunTool("simulate --quiet --scene=corridor --scan_count=1 --beams=271 --sweeps=90 "
                    "--output_dir=" +
                    Path("corridor"))
                .exit_code,
            0);
  const Outcome outcome = RunTool("locate --output=" + Path("found.json") + " " +
                                  Path("corridor/scans/scan000.ply") + Map() + Gps());
  EXPECT_EQ(outcome.exit_code, 3);
  const Json found = Json::parse(ReadTextFile(Path("found.json")));
  EXPECT_NE(found["status"], "ok");
  EXPECT_NE(found["reason"], "");
  EXPECT_THAT(outcome.err, HasSubstr(found["reason"].get<std::string>()));
}

TEST_F(LocateJob, WrongUsage) {
  const std::string both = Map() + Gps();
  for (const std::string& arguments :
       {Scan(0), both, Scan(0) + both + " --map_scale=8", Scan(0) + both + " --method=luck",
        Scan(0) + Map() + " --map_scale=0", Scan(0) + Map() + " --map_scale=-3",
        Scan(0) + Map() + " --map_scale=8:9", Scan(0) + Map() + " --map_scale=nan",
        Scan(0) + Map() + " --gps=" + Path("yard/uav/gps.csv"),
        Scan(0) + " " + Scan(1) + both + " --odometry=" + Path("yard/odometry.tum") +
            " --method=nothing"}) {
    const Outcome outcome = RunTool("locate " + arguments);
    EXPECT_EQ(outcome.exit_code, 1) << arguments << outcome.err;
    EXPECT_THAT(outcome.out, testing::IsEmpty());
  }
}

TEST_F(LocateJob, BadInputIsNamed) {
  const std::string broken = Write("broken.ply", "ply\nformat ascii 1.0\nelement vertex x\n");
  const std::string missing = Path("missing.ply");
  for (const auto& [arguments, file] :
       {std::pair{Scan(0) + " --map=" + missing + " --map_scale=8", missing},
        std::pair{missing + Map() + Gps(), missing}, std::pair{broken + Map() + Gps(), broken},
        std::pair{Scan(0) + " --map=" + broken + " --map_scale=8", broken}}) {
    const Outcome outcome = RunTool("locate " + arguments);
    EXPECT_EQ(outcome.exit_code, 2) << arguments;
    EXPECT_THAT(outcome.err, HasSubstr(file));
  }
  // One pose for each scan.
  const std::string odometry = Write("two.tum", "0 0 0 0 0 0 0 1\n1 1 0 0 0 0 0 1\n");
  const Outcome outcome = RunTool("locate " + Scan(0) + Map() + Gps() + " --odometry=" + odometry);
  EXPECT_EQ(outcome.exit_code, 2);
  EXPECT_THAT(outcome.err, HasSubstr("has 2 poses for 1 scans"));
}

}  // namespace
}  // namespace planegraph::cli
