#include "planegraph/sweep/experiment.h"

#include <gmock/gmock.h>

#include <random>

#include "io/test_files.h"

namespace planegraph {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::Pair;
using ::testing::UnorderedElementsAre;

// A tool whose `map` has the flag loss and whose `simulate` has the flag scene.
std::string CheckFlag(const std::string& command, const std::string& flag,
                      const std::string& value) {
  if (flag != (command == "map" ? "loss" : "scene")) return command + " has no flag " + flag;
  return value == "bad" ? "the flag cannot be bad" : "";
}

class ExperimentFile : public TestFolder {
 protected:
  ExperimentFile() { Write("data/site.yaml", "robots: []\n"); }

  Experiment Read(const std::string& text) {
    return ReadExperiment(Write("e.yaml", text), "", CheckFlag);
  }
  void ExpectError(const std::string& text, const std::string& place, const std::string& words) {
    SCOPED_TRACE(text);
    try {
      Read(text);
      FAIL() << "no error";
    } catch (const InputError& error) {
      EXPECT_EQ(error.file(), Path("e.yaml"));
      EXPECT_EQ(error.place(), place);
      EXPECT_THAT(error.reason(), HasSubstr(words));
    }
  }
};

TEST_F(ExperimentFile, ReadsEveryKey) {
  const Experiment e = Read(R"(name: losses
seeds: [0..2, 7]
threads: 2
level: 0.9
keep: results
baseline: b
data_sets:
  - {name: real, site: data/site.yaml, truth: data/site.yaml, seeds: 5}
  - {name: sim, simulate: {scene: yard}, map_file: site_nostart.yaml}
variants:
  - name: a
  - {name: b, flags: {loss: "cauchy:2"}}
metrics:
  - ate_rmse
  - {name: nees, report: /reference/consistency/pose_nees, of: max, unit: m, ratio: true}
)");
  EXPECT_EQ(e.name, "losses");
  EXPECT_EQ(e.threads, 2);
  EXPECT_EQ(e.level, 0.9);
  EXPECT_FALSE(e.keeps_everything);
  EXPECT_EQ(e.baseline, 1u);
  ASSERT_EQ(e.data_sets.size(), 2u);
  EXPECT_EQ(e.data_sets[0].site, Path("data/site.yaml"));
  EXPECT_EQ(e.data_sets[0].truth, Path("data/site.yaml"));
  EXPECT_THAT(e.data_sets[0].seeds, ElementsAre(5u));
  EXPECT_TRUE(e.data_sets[1].is_simulated());
  EXPECT_EQ(e.data_sets[1].map_file, "site_nostart.yaml");
  EXPECT_THAT(e.data_sets[1].simulate, UnorderedElementsAre(Pair("scene", "yard")));
  EXPECT_THAT(e.data_sets[1].seeds, ElementsAre(0u, 1u, 2u, 7u));
  ASSERT_EQ(e.variants.size(), 2u);
  EXPECT_TRUE(e.variants[0].flags.empty());
  EXPECT_THAT(e.variants[1].flags, UnorderedElementsAre(Pair("loss", "cauchy:2")));
  ASSERT_EQ(e.metrics.size(), 2u);
  EXPECT_EQ(e.metrics[0].unit, "m");
  EXPECT_EQ(e.metrics[1].pointer, "/reference/consistency/pose_nees");
  EXPECT_EQ(e.metrics[1].aggregate, Aggregate::kMax);
  EXPECT_TRUE(e.metrics[1].is_ratio);
}

constexpr char kSets[] = "data_sets: [{name: s, simulate: {scene: yard}}]\n";
constexpr char kVariants[] = "variants: [{name: a}]\n";

TEST_F(ExperimentFile, WhatIsNotSaidHasDefaults) {
  const Experiment e = Read(std::string(kSets) + kVariants);
  EXPECT_EQ(e.name, "e");
  EXPECT_EQ(e.baseline, 0u);
  EXPECT_EQ(e.threads, 1);
  EXPECT_TRUE(e.keeps_everything);
  EXPECT_TRUE(e.has_default_metrics);
  EXPECT_THAT(e.data_sets[0].seeds, ElementsAre(0u));
  EXPECT_EQ(e.metrics.front().name, "ate_rmse");
  EXPECT_EQ(e.metrics.back().name, "cpu_seconds");
}

TEST_F(ExperimentFile, SitesCanBeRelativeToAnotherFolder) {
  const std::string path =
      Write("elsewhere/e.yaml", std::string(kVariants) + "data_sets: [{name: s, site: site.yaml}]");
  EXPECT_EQ(ReadExperiment(path, Path("data"), CheckFlag).data_sets[0].site,
            Path("data/site.yaml"));
  EXPECT_THROW(ReadExperiment(path, "", CheckFlag), InputError);
}

TEST_F(ExperimentFile, MistakesNameTheirLine) {
  const std::string sets = kSets, variants = kVariants;
  ExpectError(sets + variants + "seed: 1\n", "3", "unknown key 'seed'");
  ExpectError(sets + "variants:\n- {name: a}\n- {name: b, flag: {loss: x}}\n", "4", "unknown key");
  ExpectError(sets + "variants:\n- name: a\n  flags:\n    los: x\n", "5", "map has no flag los");
  ExpectError(sets + "variants:\n- {name: a, flags: {loss: bad}}\n", "3", "cannot be bad");
  ExpectError(sets + "variants:\n- {name: a, flags: [loss]}\n", "3", "`name: value`");
  ExpectError(variants + "data_sets:\n- {name: s, simulate: {loss: x}}\n", "3",
              "simulate has no flag loss");
  ExpectError(variants + "data_sets:\n- {name: s, site: nowhere.yaml}\n", "3", "there is no");
  ExpectError(variants + "data_sets:\n- {name: s}\n", "3", "either `site`");
  ExpectError(variants + "data_sets:\n- {name: s, site: data/site.yaml, simulate: {}}\n", "3",
              "either `site`");
  ExpectError(variants + "data_sets:\n- {name: all, simulate: {}}\n", "3", "taken");
  ExpectError(variants + "data_sets:\n- {name: ../up, simulate: {}}\n", "3", "a name is made of");
  ExpectError(variants + "data_sets:\n- {simulate: {}}\n", "3", "needs a `name`");
  ExpectError(sets + "variants:\n- {name: a}\n- {name: a}\n", "4", "taken");
  ExpectError(sets + variants + "baseline: b\n", "3", "there is no variant b");
  ExpectError(sets + variants + "metrics: [ate]\n", "3", "unknown metric 'ate'");
  ExpectError(sets + variants + "metrics: [ate_rmse, ate_rmse]\n", "3", "there already");
  ExpectError(sets + variants + "metrics: [{name: a, report: b}]\n", "3", "begins with a slash");
  ExpectError(sets + variants + "metrics: [{name: a, report: /b~2}]\n", "3", "tilde");
  ExpectError(sets + variants + "metrics: [{name: a, report: /b, of: sumo}]\n", "3", "not sumo");
  ExpectError(sets + variants + "level: 1\n", "3", "between 0 and 1");
  ExpectError(sets + variants + "threads: -1\n", "3", "`threads`");
  ExpectError(sets + variants + "threads: many\n", "3", "not of the right kind");
  ExpectError(sets + variants + "keep: nothing\n", "3", "everything or results");
  ExpectError(variants, "1", "`data_sets` is a list");
  ExpectError(sets + "variants: []\n", "2", "`variants` is a list");
  ExpectError("- 1\n", "1", "is not an experiment");
  ExpectError("a: [\n", "2", "is not valid YAML");
}

TEST_F(ExperimentFile, AGridIsEveryCombination) {
  const FlagCheck any = [](const auto&, const auto&, const auto& value) {
    return std::string(value == "bad" ? "bad flag" : "");
  };
  const std::string path = Write("g.yaml", std::string(kSets) + R"(variants:
- {name: first}
- grid: {factor: [moments, pose_pose], loss: [none, "huber:2", cauchy]}
  flags: {optimizer: graph}
)");
  const Experiment e = ReadExperiment(path, "", any);
  std::vector<std::string> names;
  for (const SweepVariant& variant : e.variants) names.push_back(variant.name);
  EXPECT_THAT(names, ElementsAre("first", "moments_none", "moments_huber:2", "moments_cauchy",
                                 "pose_pose_none", "pose_pose_huber:2", "pose_pose_cauchy"));
  EXPECT_THAT(e.variants[5].flags,
              UnorderedElementsAre(Pair("factor", "pose_pose"), Pair("loss", "huber:2"),
                                   Pair("optimizer", "graph")));
  const std::string sets = kSets;
  ExpectError(sets + "variants:\n- grid: {loss: [good, bad]}\n", "3", "cannot be bad");
  ExpectError(sets + "variants:\n- grid: {loss: a}\n", "3", "`loss` is a list");
  ExpectError(sets + "variants:\n- grid: {}\n", "3", "`flag: [values]`");
  ExpectError(sets + "variants:\n- {grid: {loss: [a]}, name: b}\n", "3", "unknown key 'name'");
  ExpectError(sets + "variants:\n- {grid: {loss: [a, a]}}\n", "3", "taken");
  ExpectError(sets + "variants:\n- {grid: {loss: [a]}, flags: {loss: b}}\n", "3", "given twice");
}

// Damaged files are read or refused, and nothing else.
TEST_F(ExperimentFile, DamageIsRefused) {
  const std::string good =
      "name: n\nseeds: [0..2]\nbaseline: a\nthreads: 2\nlevel: 0.9\nkeep: results\n"
      "data_sets:\n- {name: s, simulate: {scene: yard}, map_file: x, seeds: 1}\n"
      "- {name: t, site: data/site.yaml, truth: data/site.yaml}\nvariants:\n- {name: a, flags: "
      "{loss: x}}\n- {grid: {loss: [b, c]}}\nmetrics: [mme, {name: m, report: /a, of: max}]\n";
  Read(good);
  std::mt19937 random(6);
  const std::string pieces[] = {"[",  "]",   "{",  "}", ":", "- ", "\n",
                                "  ", "&a ", "*a", "~", "0", ""};
  for (int trial = 0; trial < 1500; ++trial) {
    std::string text = good;
    for (int k = 0; k < 1 + trial % 3; ++k) {
      text.replace(random() % text.size(), random() % 4, pieces[random() % 13]);
    }
    try {
      Read(text);
    } catch (const InputError&) {
    }
  }
}

TEST_F(ExperimentFile, SeedsAreNumbersAndRanges) {
  const std::string rest = std::string(kSets) + kVariants;
  EXPECT_THAT(Read(rest + "seeds: 3\n").data_sets[0].seeds, ElementsAre(3u));
  EXPECT_THAT(Read(rest + "seeds: 3..5\n").data_sets[0].seeds, ElementsAre(3u, 4u, 5u));
  for (const char* bad : {"[]", "x", "-1", "1.5", "5..3", "1..", "..1", "1...3", "0..99999999999",
                          "{a: 1}", "18446744073709551616", "[1, 1]", "[0..3, 2]"}) {
    ExpectError(rest + "seeds: " + bad + "\n", "3", "");
  }
  EXPECT_THAT(Read(rest + "seeds: 18446744073709551615\n").data_sets[0].seeds,
              ElementsAre(18446744073709551615u));
}

}  // namespace
}  // namespace planegraph
