// Sweeps with a small script in the tool's place: what is done, what is not done again.
#include "planegraph/sweep/sweep.h"

#include <gmock/gmock.h>
#include <signal.h>
#include <sys/stat.h>
#include <sys/wait.h>

#include <algorithm>
#include <chrono>
#include <fstream>
#include <sstream>
#include <thread>

#include "io/test_files.h"

namespace planegraph {
namespace {

namespace fs = std::filesystem;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Optional;
using ::testing::UnorderedElementsAre;

// Notes each call in the file `calls`. `map` fails as its flag `loss` says, and waits for the file
// `go` where that is `wait`; its report holds the seed.
constexpr char kTool[] = R"sh(#!/bin/bash
here=$(dirname "$0") command=$1 loss=none
for argument in "$@"; do
  case $argument in
    --output_dir=*) out=${argument#*=} ;;
    --seed=*) seed=${argument#*=} ;;
    --loss=*) loss=${argument#*=} ;;
  esac
done
[ $loss != wait ] || [ -e "$here/go" ] || { echo $$ > "$here/waiting"; exec sleep 60; }
echo "$command $loss $seed" >> "$here/calls"
case $command:$loss in
  simulate:*) echo "robots: []" > "$out/site.yaml" ;;
  map:lost) echo "warning: hm" >&2; echo "error: nothing matched" >&2; exit 3 ;;
  map:wrong) echo "error: unknown loss" >&2; exit 1 ;;
  map:killed) kill -9 $$ ;;
  map:*) echo "{\"value\": $seed}" > "$out/report.json"; : > "$out/map.ply" ;;
esac
)sh";

class SweepRuns : public TestFolder {
 protected:
  SweepRuns() {
    Write("tool", kTool);
    ::chmod(Path("tool").c_str(), 0755);
  }

  // An experiment on a simulated site with variants that are called as their loss.
  Experiment Simulated(const std::vector<std::string>& losses, std::vector<std::uint64_t> seeds) {
    Experiment experiment;
    experiment.path = Path("e.yaml");
    SweepDataSet& set = experiment.data_sets.emplace_back();
    set.name = "s";
    set.map_file = "site.yaml";
    set.seeds = std::move(seeds);
    for (const std::string& loss : losses) AddVariant(loss, &experiment);
    SweepMetric metric;
    metric.name = "value";
    metric.pointer = "/value";
    experiment.metrics = {metric};
    return experiment;
  }
  void AddVariant(const std::string& loss, Experiment* experiment) {
    SweepVariant variant;
    variant.name = loss;
    variant.flags = {{"loss", loss}};
    variant.line = 7;
    experiment->variants.push_back(variant);
  }
  std::vector<SweepRun> Run(const Experiment& experiment, int jobs = 2) {
    SweepOptions options;
    options.program = Path("tool");
    options.folder = Path("out");
    options.jobs = jobs;
    return RunSweep(experiment, options);
  }
  // The calls since the last time that they were asked for, sorted.
  std::vector<std::string> Calls() {
    std::ifstream stream(Path("calls"));
    std::vector<std::string> calls;
    for (std::string line; std::getline(stream, line);) calls.push_back(line);
    fs::remove(Path("calls"));
    std::sort(calls.begin(), calls.end());
    return calls;
  }
  bool WaitFor(const std::function<bool()>& condition) {
    for (int k = 0; k < 2000; ++k) {
      if (condition()) return true;
      std::this_thread::sleep_for(std::chrono::milliseconds(10));
    }
    return false;
  }
};

TEST_F(SweepRuns, EachIsDoneOnce) {
  const Experiment experiment = Simulated({"a", "b"}, {4, 5});
  const auto runs = Run(experiment);
  EXPECT_THAT(Calls(), ElementsAre("map a 4", "map a 5", "map b 4", "map b 5", "simulate none 4",
                                   "simulate none 5"));
  ASSERT_EQ(runs.size(), 4u);
  for (const SweepRun& run : runs) {
    EXPECT_TRUE(run.succeeded());
    EXPECT_FALSE(run.reused);
    EXPECT_THAT(run.values, ElementsAre(Optional(static_cast<double>(run.seed))));
    EXPECT_TRUE(fs::exists(run.folder + "/map.log"));
  }
  const auto again = Run(experiment);
  EXPECT_THAT(Calls(), IsEmpty());
  for (const SweepRun& run : again) {
    EXPECT_TRUE(run.reused);
    EXPECT_THAT(run.values, ElementsAre(Optional(static_cast<double>(run.seed))));
  }
}

TEST_F(SweepRuns, AChangedFlagRedoesItsOwnRuns) {
  Experiment experiment = Simulated({"a", "b"}, {0, 1});
  Run(experiment);
  Calls();
  experiment.variants[1].flags["loss"] = "c";
  Run(experiment);
  EXPECT_THAT(Calls(), ElementsAre("map c 0", "map c 1"));
  experiment.data_sets[0].seeds.push_back(2);
  Run(experiment);
  EXPECT_THAT(Calls(), ElementsAre("map a 2", "map c 2", "simulate none 2"));
  experiment.data_sets[0].simulate["scene"] = "hall";
  Run(experiment);
  EXPECT_EQ(Calls().size(), 9u);
}

TEST_F(SweepRuns, AChangedInputRedoesItsRuns) {
  Experiment experiment = Simulated({"a"}, {0});
  Write("data/scans/a.xyz", "1 2 3\n");
  Write("data/odometry.tum", "0 0 0 0 0 0 0 1\n");
  experiment.data_sets[0].site =
      Write("data/site.yaml", "robots: [{name: r, scans: scans, odometry: odometry.tum}]\n");
  Run(experiment);
  EXPECT_THAT(Calls(), ElementsAre("map a 0"));
  Run(experiment);
  EXPECT_THAT(Calls(), IsEmpty());
  Write("data/scans/a.xyz", "1 2 3\n4 5 6\n");
  Run(experiment);
  EXPECT_THAT(Calls(), ElementsAre("map a 0"));
  Write("data/odometry.tum", "0 1 0 0 0 0 0 1\n");
  Run(experiment);
  EXPECT_THAT(Calls(), ElementsAre("map a 0"));
  Write("data/site.yaml", "robots: [{name: q, scans: scans, odometry: odometry.tum}]\n");
  Run(experiment);
  EXPECT_THAT(Calls(), ElementsAre("map a 0"));
}

TEST_F(SweepRuns, FilesOfTruthAndOfPositionsAreInputsToo) {
  Experiment experiment = Simulated({"a"}, {0});
  Write("data/scans/a.xyz", "1 2 3\n");
  Write("data/odometry.tum", "0 0 0 0 0 0 0 1\n");
  Write("data/cloud.ply", "ply\n");
  Write("data/gps.csv", "time,lat,lon,alt\n0,51,7,99\n");
  Write("data/truth.json", R"({"scale": 2})");
  experiment.data_sets[0].site =
      Write("data/site.yaml",
            "robots: [{name: r, scans: scans, odometry: odometry.tum, gps: gps.csv}]\n"
            "maps: [{name: m, cloud: cloud.ply, reference: truth.json}]\n");
  Run(experiment);
  EXPECT_THAT(Calls(), ElementsAre("map a 0"));
  Write("data/gps.csv", "time,lat,lon,alt\n0,51,7,100\n");
  Run(experiment);
  EXPECT_THAT(Calls(), ElementsAre("map a 0"));
  Write("data/truth.json", R"({"scale": 2.5})");
  Run(experiment);
  EXPECT_THAT(Calls(), ElementsAre("map a 0"));
  Run(experiment);
  EXPECT_THAT(Calls(), IsEmpty());
}

TEST_F(SweepRuns, AChangedToolRedoesEverything) {
  const Experiment experiment = Simulated({"a"}, {0});
  Run(experiment);
  Calls();
  Write("tool", std::string(kTool) + "# another version\n");
  ::chmod(Path("tool").c_str(), 0755);
  Run(experiment);
  EXPECT_THAT(Calls(), ElementsAre("map a 0", "simulate none 0"));
}

TEST_F(SweepRuns, AFailureIsARowWithItsReason) {
  const Experiment experiment = Simulated({"a", "lost"}, {0});
  for (int call = 0; call < 2; ++call) {
    const auto runs = Run(experiment);
    EXPECT_EQ(runs[0].exit_code, 0);
    EXPECT_EQ(runs[1].exit_code, 3);
    EXPECT_EQ(runs[1].reason, "nothing matched");
    EXPECT_THAT(runs[1].values, ElementsAre(std::nullopt));
  }
  EXPECT_THAT(Calls(), ElementsAre("map a 0", "map lost 0", "simulate none 0"));
}

TEST_F(SweepRuns, WhatASignalEndedIsTriedAgain) {
  const Experiment experiment = Simulated({"killed"}, {0});
  for (int call = 0; call < 2; ++call) {
    const SweepRun run = Run(experiment)[0];
    EXPECT_EQ(run.exit_code, 128 + 9);
    EXPECT_EQ(run.reason, "ended by signal 9");
  }
  EXPECT_THAT(Calls(), ElementsAre("map killed 0", "map killed 0", "simulate none 0"));
}

TEST_F(SweepRuns, FlagsThatTheToolRefusesAreAMistakeOfTheExperiment) {
  try {
    Run(Simulated({"wrong"}, {0, 1, 2, 3}), 1);
    FAIL() << "no error";
  } catch (const InputError& error) {
    EXPECT_EQ(error.file(), Path("e.yaml"));
    EXPECT_EQ(error.place(), "7");
    EXPECT_THAT(error.reason(), HasSubstr("unknown loss"));
  }
  EXPECT_EQ(Calls().size(), 2u);  // nothing was begun after it
}

TEST_F(SweepRuns, ADamagedRecordIsNone) {
  const Experiment experiment = Simulated({"a"}, {0});
  const std::string record = Run(experiment)[0].folder + "/map.record.json";
  Calls();
  for (const char* text : {"", "{", "[]", "{\"key\": 1}"}) {
    WriteTextFile(record, text);
    Run(experiment);
    EXPECT_THAT(Calls(), ElementsAre("map a 0")) << text;
  }
}

TEST_F(SweepRuns, ResultsAloneAreKeptWhereThatIsWanted) {
  Experiment experiment = Simulated({"a"}, {0});
  experiment.keeps_everything = false;
  const SweepRun run = Run(experiment)[0];
  EXPECT_TRUE(fs::exists(run.folder + "/report.json"));
  EXPECT_TRUE(fs::exists(run.folder + "/map.log"));
  EXPECT_FALSE(fs::exists(run.folder + "/map.ply"));
  EXPECT_FALSE(fs::exists(Path("out/sites/s/0/site.yaml")));
  Calls();
  EXPECT_TRUE(Run(experiment)[0].reused);
  EXPECT_THAT(Calls(), IsEmpty());
  AddVariant("b", &experiment);  // the site is simulated again for it
  Run(experiment);
  EXPECT_THAT(Calls(), ElementsAre("map b 0", "simulate none 0"));
}

// The sweep is killed while two runs are under way: they alone are lost, and their processes with
// it.
TEST_F(SweepRuns, AKillLosesOnlyTheRunsUnderWay) {
  const Experiment experiment = Simulated({"a", "wait"}, {0});
  const pid_t sweep = ::fork();
  if (sweep == 0) {
    Run(experiment, 1);
    ::_exit(0);
  }
  ASSERT_TRUE(WaitFor([&] { return fs::exists(Path("waiting")); }));
  pid_t child = 0;
  ASSERT_TRUE(WaitFor([&] { return static_cast<bool>(std::ifstream(Path("waiting")) >> child); }));
  ::kill(sweep, SIGKILL);
  ::waitpid(sweep, nullptr, 0);
  EXPECT_TRUE(WaitFor([&] { return ::kill(child, 0) != 0; })) << "the run outlives its sweep";
  EXPECT_THAT(Calls(), ElementsAre("map a 0", "simulate none 0"));
  Write("go", "");
  const auto runs = Run(experiment);
  EXPECT_THAT(Calls(), ElementsAre("map wait 0"));
  EXPECT_TRUE(runs[0].reused);
  EXPECT_FALSE(runs[1].reused);
  EXPECT_TRUE(runs[1].succeeded());
}

TEST_F(SweepRuns, TwoSweepsDoNotShareAFolder) {
  const Experiment experiment = Simulated({"wait"}, {0});
  const pid_t sweep = ::fork();
  if (sweep == 0) {
    Run(experiment, 1);
    ::_exit(0);
  }
  ASSERT_TRUE(WaitFor([&] { return fs::exists(Path("waiting")); }));
  EXPECT_THROW(Run(experiment), UsageError);
  ::kill(sweep, SIGKILL);
  ::waitpid(sweep, nullptr, 0);
}

TEST_F(SweepRuns, TheNumberOfJobsDoesNotMatter) {
  const Experiment experiment = Simulated({"a", "b", "lost"}, {0, 1, 2});
  std::vector<std::string> seen;
  for (int jobs : {1, 4}) {
    std::ostringstream text;
    for (const SweepRun& run : Run(experiment, jobs)) {
      text << run.data_set << run.variant << run.seed << run.exit_code
           << run.values[0].value_or(-1);
    }
    seen.push_back(text.str());
    fs::remove_all(Path("out"));
  }
  EXPECT_EQ(seen[0], seen[1]);
}

}  // namespace
}  // namespace planegraph
