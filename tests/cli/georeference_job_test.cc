// `planegraph georeference` as a whole: result, exit codes, messages.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "cli/tool_runner.h"
#include "io/test_files.h"

namespace planegraph::cli {
namespace {

using ::testing::HasSubstr;

// Four cameras without rotation at (0,0,0), (1,0,0), (0,1,0), (0,0,1): the translation is minus the
// centre.
const std::string kCameras =
    "1 1 0 0 0 0 0 0 1 a.jpg\n\n2 1 0 0 0 -1 0 0 1 b.jpg\n\n3 1 0 0 0 0 -1 0 1 c.jpg\n\n"
    "4 1 0 0 0 0 0 -1 1 d.jpg\n\n";

class GeoreferenceJob : public TestFolder {
 protected:
  GeoreferenceJob() { Write("images.txt", kCameras); }
  Outcome Run(const std::string& gps, const std::string& flags = "") const {
    return RunTool("georeference --cameras=" + Path("images.txt") + " --gps=" +
                   Write("gps.csv", gps) + " --output=" + Path("out.json") + " " + flags);
  }
  nlohmann::json Result() const { return nlohmann::json::parse(ReadTextFile(Path("out.json"))); }
};

// Ten metres per unit, then a shift.
const std::string kMetric =
    "image,x,y,z\na.jpg,100,200,300\nb.jpg,110,200,300\nc.jpg,100,210,300\nd.jpg,100,200,310\n";

TEST_F(GeoreferenceJob, MetricPositions) {
  const Outcome outcome = Run(kMetric);
  EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_THAT(outcome.out, HasSubstr("scale 10.0000"));
  const nlohmann::json result = Result();
  EXPECT_NEAR(result["world_from_map"]["scale"].get<double>(), 10.0, 1e-9);
  EXPECT_NEAR(result["world_from_map"]["rotation"][3].get<double>(), 1.0, 1e-9);
  EXPECT_NEAR(result["world_from_map"]["translation"][1].get<double>(), 200.0, 1e-6);
  EXPECT_EQ(result["inliers"], nlohmann::json({0, 1, 2, 3}));
  EXPECT_EQ(result["status"], "ok");
  EXPECT_TRUE(result["origin"].is_null());
  EXPECT_EQ(result["covariance"].size(), 49u);
  EXPECT_EQ(result["planegraph"]["seed"], 0);
}

TEST_F(GeoreferenceJob, DegeneratePositionsAreStillWritten) {
  const Outcome outcome = Run("image,x,y,z\na.jpg,100,200,300\nb.jpg,110,200,300\n");
  EXPECT_EQ(outcome.exit_code, 3);
  EXPECT_THAT(outcome.err, HasSubstr("error: degenerate: only 2 of 4"));
  EXPECT_EQ(Result()["status"], "degenerate");
  EXPECT_TRUE(Result()["world_from_map"].is_null());
}

TEST_F(GeoreferenceJob, TheOriginIsEchoed) {
  const std::string gps =
      "image,lat,lon,alt\na.jpg,51,7,100\nb.jpg,51.001,7,100\nc.jpg,51,7.002,100\nd.jpg,51,7,180\n";
  Run(gps);
  EXPECT_EQ(Result()["origin"], nlohmann::json({{"lat", 51.0}, {"lon", 7.0}, {"alt", 100.0}}));
  Run(gps, "--origin=51.5,7.5,90");
  EXPECT_EQ(Result()["origin"], nlohmann::json({{"lat", 51.5}, {"lon", 7.5}, {"alt", 90.0}}));
}

TEST_F(GeoreferenceJob, WrongUsage) {
  const std::string by_time = "time,lat,lon,alt\n1,51,7,100\n";
  const std::pair<std::string, std::string> flags[] = {{"--method=best", "--method must be"},
                                                       {"--origin=1,2", "--origin takes"},
                                                       {"--origin=91,2,3", "no place on earth"},
                                                       {"--origin=a,2,3", "not a number"},
                                                       {"", "--image_times is needed"}};
  for (const auto& [flag, words] : flags) {
    const Outcome outcome = Run(by_time, flag);
    EXPECT_EQ(outcome.exit_code, 1) << flag;
    EXPECT_THAT(outcome.err, HasSubstr(words));
  }
  EXPECT_EQ(RunTool("georeference --cameras=x").exit_code, 1);
  EXPECT_EQ(RunTool("georeference --gps=x").exit_code, 1);
}

TEST_F(GeoreferenceJob, BadInput) {
  EXPECT_EQ(Run("image,x,y,z\na.jpg,1,2,x\n").exit_code, 2);
  const std::string times = Write("times.csv", "time,file\n1,a.jpg\n2,b.jpg\n");
  const Outcome outcome =
      Run("time,lat,lon,alt\n1,51,7,100\n2,51,7,100\n", "--image_times=" + times);
  EXPECT_EQ(outcome.exit_code, 2);
  EXPECT_THAT(outcome.err, HasSubstr(times + ": 2 images, but there are 4 cameras"));
}

}  // namespace
}  // namespace planegraph::cli
