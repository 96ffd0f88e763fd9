// Sweeps by the built tool over tiny simulated sites.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "cli/tool_runner.h"
#include "io/test_files.h"

namespace planegraph::cli {
namespace {

using ::testing::HasSubstr;
using ::testing::StartsWith;

class SweepJobs : public TestFolder {
 protected:
  std::string Experiment(const std::string& variants, const std::string& more = "") {
    return Write("e.yaml", R"(name: tiny
seeds: [0, 1]
data_sets:
  - {name: corridor, simulate: {scene: corridor, scan_count: 3, beams: 271, sweeps: 90}}
variants:
)" + variants + more);
  }
  Outcome Sweep(const std::string& experiment, const std::string& flags = "--json") {
    return RunTool("sweep " + experiment + " --threads=2 --output_dir=" + Path("out") + " " +
                   flags);
  }
};

constexpr char kTwo[] = "  - {name: graph}\n  - {name: chain, flags: {optimizer: none}}\n";

TEST_F(SweepJobs, TwoVariantsAndTwoSeeds) {
  const std::string experiment = Experiment(kTwo);
  const Outcome first = Sweep(experiment);
  const auto json = nlohmann::json::parse(first.out);
  EXPECT_EQ(json["runs"], 4);
  EXPECT_EQ(json["carried_out"], 4);
  EXPECT_EQ(json["baseline"], "graph");
  ASSERT_EQ(json["table"].size(), 2u);
  for (const auto& row : json["table"]) EXPECT_EQ(row["runs"], 2);
  EXPECT_EQ(json, nlohmann::json::parse(ReadTextFile(Path("out/sweep.json"))));
  for (const char* name : {"sweep.csv", "table.csv", "table.html", "table.tex", "table.md"}) {
    EXPECT_TRUE(std::filesystem::is_regular_file(Path("out/") + name)) << name;
  }
  const std::string csv = ReadTextFile(Path("out/sweep.csv"));
  const Outcome second = Sweep(experiment);
  EXPECT_EQ(second.exit_code, first.exit_code);
  EXPECT_EQ(nlohmann::json::parse(second.out)["carried_out"], 0);
  EXPECT_EQ(ReadTextFile(Path("out/sweep.csv")), csv);
}

TEST_F(SweepJobs, MistakesNameTheirLine) {
  const Outcome flag = Sweep(Experiment("  - {name: a, flags: {optimiser: none}}\n"));
  EXPECT_EQ(flag.exit_code, 2);
  EXPECT_THAT(flag.err, StartsWith("error: " + Path("e.yaml") + ":6: "));
  EXPECT_THAT(flag.err, HasSubstr("no flag optimiser"));
  const Outcome type = Sweep(Experiment("  - {name: a, flags: {map_voxel: wide}}\n"));
  EXPECT_EQ(type.exit_code, 2);
  EXPECT_THAT(type.err, HasSubstr("cannot be 'wide'"));
  const Outcome value = Sweep(Experiment("  - {name: a, flags: {loss: no_such_loss}}\n"));
  EXPECT_EQ(value.exit_code, 2);
  EXPECT_THAT(value.err, HasSubstr(":6: the variant a fails: "));
  const Outcome folder = Sweep(Experiment("  - {name: a, flags: {output_dir: x}}\n"));
  EXPECT_EQ(folder.exit_code, 2);
  EXPECT_EQ(RunTool("sweep " + Experiment(kTwo)).exit_code, 1);  // no --output_dir
}

TEST_F(SweepJobs, WithoutASuccessThereIsNoResult) {
  Write("scans/a.xyz", "1 2 3\n4 five 6\n");
  Write("site.yaml", "robots: [{name: a, scans: scans}]\n");
  const std::string experiment =
      Write("e.yaml", "data_sets: [{name: s, site: site.yaml}]\nvariants: [{name: a}]\n");
  const Outcome outcome = Sweep(experiment);
  EXPECT_EQ(outcome.exit_code, 3);
  EXPECT_THAT(outcome.err, HasSubstr("error: no run of a on s succeeded"));
  const auto json = nlohmann::json::parse(outcome.out);
  EXPECT_EQ(json["failures"][0]["exit_code"], 2);
  EXPECT_THAT(json["failures"][0]["reason"].get<std::string>(), HasSubstr("a.xyz:2"));
}

}  // namespace
}  // namespace planegraph::cli
