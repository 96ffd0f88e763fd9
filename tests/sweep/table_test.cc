#include "planegraph/sweep/table.h"

#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "io/test_files.h"
#include "planegraph/evaluation/paired_test.h"
#include "report/html_checker.h"

namespace planegraph {
namespace {

using ::testing::DoubleNear;
using ::testing::HasSubstr;
using ::testing::Not;
using ::testing::Optional;

SweepMetric Metric(const std::string& name, bool is_ratio) {
  SweepMetric metric;
  metric.name = name;
  metric.is_ratio = is_ratio;
  return metric;
}

// Three variants on two simulated sites with ten seeds; an error and a time are measured.
Experiment Example(const std::vector<std::string>& variants) {
  Experiment experiment;
  experiment.name = "an <experiment>";
  for (const char* name : {"first", "second"}) {
    SweepDataSet& set = experiment.data_sets.emplace_back();
    set.name = name;
    for (std::uint64_t seed = 0; seed < 10; ++seed) set.seeds.push_back(seed);
  }
  for (const std::string& name : variants) {
    experiment.variants.emplace_back().name = name;
    if (name == "base") experiment.baseline = experiment.variants.size() - 1;
  }
  experiment.metrics = {Metric("error_m", false), Metric("seconds", true)};
  return experiment;
}

// What a run measures depends on names and seed alone. `worse` is worse by 1 + seed / 100 and takes
// twice the time; `alike` differs by noise.
SweepRun RunOf(const Experiment& experiment, std::size_t set, std::size_t variant,
               std::uint64_t seed) {
  SweepRun run;
  run.data_set = set;
  run.variant = variant;
  run.seed = seed;
  const std::string& name = experiment.variants[variant].name;
  const double s = static_cast<double>(seed);
  const double base = 3.0 + std::sin(7.0 * s) + static_cast<double>(set);
  const double noise = 0.01 * std::sin(1.0 + 5.0 * s);
  const double error = name == "worse" ? base + 1.0 + s / 100.0 : base;
  const double seconds = (5.0 + std::cos(s)) * (name == "worse" ? 2.0 : 1.0);
  run.values = {name == "alike" ? base + noise : error, seconds};
  return run;
}

std::vector<SweepRun> RunsOf(const Experiment& experiment) {
  std::vector<SweepRun> runs;
  for (std::size_t d = 0; d < experiment.data_sets.size(); ++d) {
    for (std::uint64_t seed : experiment.data_sets[d].seeds) {
      for (std::size_t v = 0; v < experiment.variants.size(); ++v) {
        runs.push_back(RunOf(experiment, d, v, seed));
      }
    }
  }
  return runs;
}

const SweepRow& RowOf(const std::vector<SweepRow>& rows, const std::string& set,
                      const std::string& variant) {
  return *std::find_if(rows.begin(), rows.end(), [&](const SweepRow& row) {
    return row.data_set == set && row.variant == variant;
  });
}

TEST(SweepTable, HasARowForEveryDataSetAndVariant) {
  const Experiment experiment = Example({"base", "worse", "alike"});
  const auto rows = MakeSweepTable(experiment, RunsOf(experiment));
  ASSERT_EQ(rows.size(), 9u);  // and for each variant over all
  const SweepRow& base = RowOf(rows, "first", "base");
  EXPECT_TRUE(base.is_baseline);
  EXPECT_EQ(base.succeeded, 10u);
  EXPECT_FALSE(base.cells[0].p);
  EXPECT_FALSE(base.cells[0].change);
  EXPECT_EQ(RowOf(rows, "all", "worse").runs, 20u);
}

TEST(SweepTable, ComparesPairs) {
  const Experiment experiment = Example({"base", "worse", "alike"});
  const auto rows = MakeSweepTable(experiment, RunsOf(experiment));
  const SweepCell& error = RowOf(rows, "first", "worse").cells[0];
  EXPECT_EQ(error.pairs, 10u);
  EXPECT_THAT(error.change, Optional(DoubleNear(1.045, 1e-12)));
  ASSERT_TRUE(error.change_interval);
  EXPECT_GT(error.change_interval->low, 1.0 - 1e-12);
  EXPECT_THAT(error.p, Optional(DoubleNear(2.0 / 1024.0, 1e-12)));             // all ten go one way
  EXPECT_THAT(error.p_holm, Optional(DoubleNear(4.0 * 2.0 / 1024.0, 1e-12)));  // of four tests
  EXPECT_GT(*RowOf(rows, "first", "alike").cells[0].p_holm, 0.05);
  const SweepCell& seconds = RowOf(rows, "second", "worse").cells[1];
  EXPECT_THAT(seconds.change, Optional(DoubleNear(2.0, 1e-12)));
  EXPECT_THAT(RowOf(rows, "second", "alike").cells[1].p, Optional(1.0));  // no difference at all
  EXPECT_EQ(RowOf(rows, "all", "worse").cells[0].pairs, 20u);
}

TEST(SweepTable, DoesNotDependOnTheOrderOfTheVariants) {
  const std::vector<std::string> order{"base", "worse", "alike"};
  const Experiment experiment = Example(order);
  const auto rows = MakeSweepTable(experiment, RunsOf(experiment));
  auto other = order;
  while (std::next_permutation(other.begin(), other.end())) {
    const Experiment permuted = Example(other);
    const auto again = MakeSweepTable(permuted, RunsOf(permuted));
    for (const SweepRow& row : rows) {
      const SweepRow& same = RowOf(again, row.data_set, row.variant);
      for (std::size_t m = 0; m < row.cells.size(); ++m) {
        EXPECT_EQ(row.cells[m].median, same.cells[m].median);
        EXPECT_EQ(row.cells[m].mean, same.cells[m].mean);
        EXPECT_EQ(row.cells[m].change, same.cells[m].change);
        EXPECT_EQ(row.cells[m].p, same.cells[m].p);
        EXPECT_EQ(row.cells[m].p_holm, same.cells[m].p_holm);
        EXPECT_EQ(row.cells[m].interval.has_value(), same.cells[m].interval.has_value());
      }
    }
  }
}

TEST(SweepTable, FailedRunsCountAsFailures) {
  const Experiment experiment = Example({"base", "worse"});
  auto runs = RunsOf(experiment);
  for (SweepRun& run : runs) {
    if (run.data_set == 0 && run.variant == 1 && run.seed < 3) run.exit_code = 3;
    if (run.data_set == 0 && run.variant == 0 && run.seed == 9) run.exit_code = 2;
  }
  const auto rows = MakeSweepTable(experiment, runs);
  const SweepRow& row = RowOf(rows, "first", "worse");
  EXPECT_EQ(row.runs, 10u);
  EXPECT_EQ(row.succeeded, 7u);
  EXPECT_EQ(row.cells[0].count, 7u);
  EXPECT_EQ(row.cells[0].pairs, 6u);  // the baseline lacks one of them
  EXPECT_EQ(RowOf(rows, "first", "base").succeeded, 9u);
  EXPECT_EQ(RowOf(rows, "all", "worse").succeeded, 17u);
}

TEST(SweepTable, EqualResultsOfTheSameFilesCountOnce) {
  Experiment experiment = Example({"base", "worse"});
  experiment.data_sets[0].site = "site.yaml";
  auto runs = RunsOf(experiment);
  for (SweepRun& run : runs) {
    if (run.data_set == 0) run.values[0] = run.variant == 0 ? 1.0 : 2.0;
  }
  const SweepRow row = RowOf(MakeSweepTable(experiment, runs), "first", "worse");
  EXPECT_EQ(row.cells[0].count, 1u);
  EXPECT_EQ(row.cells[0].pairs, 1u);
  EXPECT_FALSE(row.cells[0].p);  // ten repetitions are no evidence
  EXPECT_FALSE(row.cells[0].interval);
  EXPECT_THAT(row.cells[0].change, Optional(1.0));
  EXPECT_EQ(row.cells[1].pairs, 10u);  // times do differ
}

TEST(SweepTable, MetricsWithoutAValueCanBeLeftOut) {
  Experiment experiment = Example({"base"});
  experiment.metrics.insert(experiment.metrics.begin() + 1, Metric("none", false));
  auto runs = RunsOf(experiment);
  for (SweepRun& run : runs) run.values.insert(run.values.begin() + 1, std::nullopt);
  EXPECT_THAT(EmptyMetrics(experiment, runs), ::testing::ElementsAre("none"));
  LeaveOut("none", &experiment, &runs);
  EXPECT_EQ(experiment.metrics.size(), 2u);
  EXPECT_EQ(runs[0].values, RunsOf(experiment)[0].values);
  EXPECT_TRUE(EmptyMetrics(experiment, runs).empty());
}

class SweepFiles : public TestFolder {};

TEST_F(SweepFiles, AreWrittenInEveryForm) {
  Experiment experiment = Example({"base", "worse", "alike"});
  experiment.variants[1].flags = {{"loss", "huber:2"}};
  auto runs = RunsOf(experiment);
  runs[1].exit_code = 3;
  runs[1].reason = "no \"way\", <none>";
  const auto rows = MakeSweepTable(experiment, runs);
  WriteSweepTables(experiment, runs, rows, {"1.2.3", "abc"}, Path(""));
  const std::string csv = ReadTextFile(Path("sweep.csv"));
  EXPECT_EQ(std::count(csv.begin(), csv.end(), '\n'), 61);
  EXPECT_THAT(csv, HasSubstr("data_set,variant,seed,exit_code,reason,error_m,seconds\n"));
  EXPECT_THAT(csv, HasSubstr("first,worse,0,3,\"no \"\"way\"\", <none>\",4,12\n"));
  const std::string table = ReadTextFile(Path("table.csv"));
  EXPECT_EQ(std::count(table.begin(), table.end(), '\n'), 10);
  EXPECT_THAT(table, HasSubstr("first,worse,0,10,9,9,"));
  EXPECT_THAT(table, HasSubstr("seconds_ratio,seconds_ratio_low,seconds_ratio_high,seconds_p,"));
  const std::string html = ReadTextFile(Path("table.html"));
  EXPECT_EQ(FirstFault(html), "");
  EXPECT_THAT(html, HasSubstr("an &lt;experiment&gt;"));
  EXPECT_THAT(html, HasSubstr("no &quot;way&quot;, &lt;none&gt;"));
  EXPECT_THAT(html, HasSubstr("9 of 10"));
  EXPECT_THAT(html, HasSubstr("--loss=huber:2"));
  EXPECT_THAT(html, Not(HasSubstr("<script")));
  EXPECT_THAT(html, Not(HasSubstr("http")));
  EXPECT_THAT(html, HasSubstr("prefers-color-scheme: dark"));
  const std::string latex = ReadTextFile(Path("table.tex"));
  EXPECT_THAT(latex, HasSubstr("error\\_m"));
  EXPECT_THAT(latex, HasSubstr("\\end{tabular}"));
  const std::string markdown = ReadTextFile(Path("table.md"));
  EXPECT_THAT(markdown, HasSubstr("| first | base (baseline) | 10 of 10 |"));
  EXPECT_THAT(markdown, HasSubstr("|  | worse | 9 of 10 |"));
}

}  // namespace
}  // namespace planegraph
