// `planegraph evaluate` as a whole: result, exit codes, messages.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <nlohmann/json.hpp>
#include <sstream>

#include "cli/tool_runner.h"
#include "io/test_files.h"

namespace planegraph::cli {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

using EvaluateJob = TestFolder;

TEST_F(EvaluateJob, TakesTheScansOfASite) {
  const std::string site = Path("hall") + "/site.yaml";
  ASSERT_EQ(RunTool("simulate --quiet --scene=hall --scan_count=3 --beams=271 --sweeps=90 "
                    "--output_dir=" +
                    Path("hall"))
                .exit_code,
            0);
  const std::string truth = " --estimate=" + Path("hall/truth.tum") + " --json --voxel=0.2";
  const Outcome of_site = RunTool("evaluate --scans=" + site + truth);
  const Outcome of_folder = RunTool("evaluate --scans=" + Path("hall/scans") + truth);
  ASSERT_EQ(of_site.exit_code, 0) << of_site.err;
  const auto json = nlohmann::json::parse(of_site.out);
  EXPECT_EQ(json["point_set"], nlohmann::json::parse(of_folder.out)["point_set"]);
  EXPECT_EQ(json["mme"], nlohmann::json::parse(of_folder.out)["mme"]);
}

TEST_F(EvaluateJob, AsksWhichRobotOfASite) {
  Write("scans/a.xyz", "1 2 3\n4 5 6\n");
  const std::string two =
      Write("two.yaml", "robots: [{name: a, scans: scans}, {name: b, scans: scans}]\n");
  const std::string estimate = " --estimate=" + Write("e.tum", "0 0 0 0 0 0 0 1\n");
  const Outcome outcome = RunTool("evaluate --scans=" + two + estimate);
  EXPECT_EQ(outcome.exit_code, 1);
  EXPECT_THAT(outcome.err, HasSubstr("two.yaml has several robots"));
}

TEST_F(EvaluateJob, PositionsOnALineHaveNoAlignment) {
  const std::string line = Write("line.tum",
                                 "0 0 0 0 0 0 0 1\n1 1 0 0 0 0 0 1\n2 2 0 0 0 0 0 1\n"
                                 "3 3 0 0 0 0 0 1\n");
  const std::string both = "evaluate --reference=" + line + " --estimate=" + line;
  EXPECT_EQ(RunTool(both + " --align=se3").exit_code, 3);
  EXPECT_EQ(RunTool(both + " --align=first").exit_code, 0);
  EXPECT_EQ(RunTool(both + " --align=crooked").exit_code, 1);
}

// A curve of 12 poses whose quaternions are written by `write`.
std::string CurveTum(const std::function<std::string(double c, double s)>& write) {
  std::ostringstream text;
  for (int i = 0; i < 12; ++i) {
    const double angle = 0.3 * i;
    text << i << ' ' << 5 * std::cos(angle) << ' ' << 3 * std::sin(angle) << ' ' << 0.1 * i << ' '
         << write(std::cos(angle / 2), std::sin(angle / 2)) << '\n';
  }
  return text.str();
}

TEST_F(EvaluateJob, AFrames2tumFileIsWarnedAbout) {
  const auto join = [](double a, double b, double c, double d) {
    std::ostringstream text;
    text << a << ' ' << b << ' ' << c << ' ' << d;
    return text.str();
  };
  const std::string clean =
      Write("clean.tum", CurveTum([&](double c, double s) { return join(0, 0, s, c); }));
  const std::string doctored =
      Write("frames2tum.tum", CurveTum([&](double c, double s) { return join(-c, 0, 0, s); }));
  const std::string start = "evaluate --json --reference=" + clean + " --estimate=";
  const Outcome good = RunTool(start + clean), bad = RunTool(start + doctored);
  EXPECT_THAT(good.err, Not(HasSubstr("frames2tum writes")));
  EXPECT_THAT(bad.err, HasSubstr("frames2tum writes"));
  EXPECT_EQ(bad.exit_code, 0);
  const auto json = nlohmann::json::parse(bad.out);
  EXPECT_THAT(json["warnings"].dump(), HasSubstr("frames2tum writes"));
  EXPECT_EQ(json["ate"]["interval"]["level"], 0.95);
  EXPECT_EQ(json["ate"]["interval"]["blocks"], 12);
}

TEST_F(EvaluateJob, ComparisonsTakeEqualSets) {
  const auto identity = [](double, double) { return std::string("0 0 0 1"); };
  const std::string all = Write("all.tum", CurveTum(identity));
  const std::string lines = CurveTum(identity);
  const std::string part = Write("part.tum", lines.substr(0, lines.find("\n9 ") + 1));
  const std::string start = "evaluate --json --reference=" + all + " --estimate=" + all;
  const Outcome same = RunTool(start + " --compare=" + all);
  EXPECT_EQ(same.exit_code, 0) << same.err;
  EXPECT_EQ(nlohmann::json::parse(same.out)["compare"]["difference"]["ate"]["rmse"], 0.0);
  const Outcome unequal = RunTool(start + " --compare=" + part);
  EXPECT_EQ(unequal.exit_code, 2);
  EXPECT_THAT(unequal.err, HasSubstr("cannot be compared"));
  EXPECT_EQ(RunTool("evaluate --map=a.ply --compare=" + all).exit_code, 1);
}

TEST_F(EvaluateJob, PlotsNeedGnuplot) {
  const std::string all =
      Write("all.tum", CurveTum([](double, double) { return std::string("0 0 0 1"); }));
  const std::string start = "evaluate --quiet --reference=" + all + " --estimate=" + all;
  EXPECT_EQ(RunTool(start + " --plot=" + Path("plot.png")).exit_code, 1);
  const Outcome outcome = RunTool(start + " --plot=" + Path("plot.svg"));
  if (outcome.exit_code == 2) {
    EXPECT_THAT(outcome.err, HasSubstr("the program gnuplot is not installed"));
    GTEST_SKIP() << "gnuplot is not here";
  }
  EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_THAT(ReadTextFile(Path("plot.svg")), HasSubstr("</svg>"));
}

}  // namespace
}  // namespace planegraph::cli
