#include "sweep/metrics.h"

#include <gmock/gmock.h>

#include "io/test_files.h"
#include "sweep/json_pointer.h"

namespace planegraph {
namespace {

using ::testing::DoubleNear;
using ::testing::ElementsAre;
using ::testing::IsEmpty;
using ::testing::Optional;

// The document and the pointers of RFC 6901, section 5.
TEST(JsonPointer, ReadsTheStandardsExamples) {
  const auto json = nlohmann::json::parse(
      R"({"foo": ["bar", "baz"], "": 0, "a/b": 1, "c%d": 2, "e^f": 3, "g|h": 4, "i\\j": 5,
          "k\"l": 6, " ": 7, "m~n": 8})");
  EXPECT_THAT(FollowPointer(json, "/foo/0"), ElementsAre("bar"));
  EXPECT_THAT(FollowPointer(json, "/"), ElementsAre(0));
  EXPECT_THAT(FollowPointer(json, "/a~1b"), ElementsAre(1));
  EXPECT_THAT(FollowPointer(json, "/c%d"), ElementsAre(2));
  EXPECT_THAT(FollowPointer(json, "/i\\j"), ElementsAre(5));
  EXPECT_THAT(FollowPointer(json, "/k\"l"), ElementsAre(6));
  EXPECT_THAT(FollowPointer(json, "/ "), ElementsAre(7));
  EXPECT_THAT(FollowPointer(json, "/m~0n"), ElementsAre(8));
}

TEST(JsonPointer, AStarIsEveryMember) {
  const auto json = nlohmann::json::parse(R"({"a": {"x": {"v": 1}, "y": {"v": 2}, "z": {}}, "b":
      [[1, 2], [], [3]], "c": 4})");
  EXPECT_THAT(FollowPointer(json, "/a/*/v"), ElementsAre(1, 2));
  EXPECT_THAT(FollowPointer(json, "/b/*/*"), ElementsAre(1, 2, 3));
  EXPECT_THAT(FollowPointer(json, "/b/1"), ElementsAre(nlohmann::json::array()));
  for (const char* nowhere :
       {"/c/*", "/c/x", "/b/7", "/b/-1", "/b/x", "/b/99999999999999999999", "/a/w"}) {
    EXPECT_THAT(FollowPointer(json, nowhere), IsEmpty()) << nowhere;
  }
}

class Metrics : public TestFolder {
 protected:
  std::vector<std::optional<double>> MeasureAll(const std::vector<SweepMetric>& metrics) {
    StageRecord record;
    record.cpu_seconds = 2.5;
    return Measure(metrics, {Path(""), Path("truth.json")}, record);
  }
  std::optional<double> Of(const std::string& name) {
    return MeasureAll({*BuiltinMetric(name)})[0];
  }
  std::optional<double> At(const std::string& pointer, const std::string& aggregate = "mean") {
    SweepMetric metric;
    metric.name = "own";
    metric.pointer = pointer;
    metric.aggregate = *ParseAggregate(aggregate);
    return MeasureAll({metric})[0];
  }
};

TEST_F(Metrics, AreReadFromTheRunsFiles) {
  Write("report.json", R"({
    "evaluation": {"a": {"ate": {"rmse": 0.1}, "rpe": {"rmse": 1, "rotation": {"rmse": 0.01}}},
                   "b": {"ate": {"rmse": 0.3}}},
    "scans": [{"anchored_to": ["m"]}, {"anchored_to": []}, {"anchored_to": ["m", "n"]}, {}],
    "maps": [{"world_from_map": {"scale": 2.02}}, {"world_from_map": {"scale": 1.96}}],
    "solve": {"final_cost": 50, "redundancy": 400}})");
  Write("truth.json", R"({"scale": 2})");
  Write("evaluate.json", R"({"mme": -5, "thickness": {"median": 0.004}})");
  EXPECT_THAT(Of("ate_rmse"), Optional(DoubleNear(0.2, 1e-12)));
  EXPECT_THAT(Of("rpe_translation"), Optional(1.0));
  EXPECT_THAT(Of("rpe_rotation"), Optional(0.01));
  EXPECT_THAT(Of("anchored"), Optional(0.5));
  EXPECT_THAT(Of("scale_error"), Optional(DoubleNear(0.015, 1e-12)));
  EXPECT_THAT(Of("residual"), Optional(0.5));
  EXPECT_THAT(Of("mme"), Optional(-5.0));
  EXPECT_THAT(Of("thickness"), Optional(0.004));
  EXPECT_THAT(Of("cpu_seconds"), Optional(2.5));
}

TEST_F(Metrics, WhatARunDoesNotSayHasNoValue) {
  for (const char* report : {"", "{}", "[]", "{\"scans\": 1, \"maps\": null", "7",
                             "{\"evaluation\": {\"a\": {\"ate\": {\"rmse\": null}}}}"}) {
    SCOPED_TRACE(report);
    Write("report.json", report);
    for (const char* name : {"ate_rmse", "rpe_translation", "rpe_rotation", "anchored",
                             "scale_error", "residual", "mme", "thickness"}) {
      EXPECT_FALSE(Of(name)) << name;
    }
    EXPECT_FALSE(At("/own"));
  }
}

TEST_F(Metrics, ManyNumbersBecomeOne) {
  Write("report.json", R"({"v": [4, null, 1, true, "text", 10], "yes": true, "none": []})");
  EXPECT_THAT(At("/v/*"), Optional(4.0));
  EXPECT_THAT(At("/v/*", "median"), Optional(2.5));
  EXPECT_THAT(At("/v/*", "max"), Optional(10.0));
  EXPECT_THAT(At("/v/*", "min"), Optional(1.0));
  EXPECT_THAT(At("/v/*", "sum"), Optional(16.0));
  EXPECT_THAT(At("/v/*", "count"), Optional(5.0));
  EXPECT_THAT(At("/none/*", "count"), Optional(0.0));
  EXPECT_THAT(At("/yes"), Optional(1.0));
  EXPECT_FALSE(At("/none/*", "sum"));
}

TEST(MetricNames, AreKnown) {
  EXPECT_FALSE(BuiltinMetric("ate"));
  EXPECT_FALSE(ParseAggregate("average"));
  EXPECT_TRUE(NeedsSharpness({*BuiltinMetric("ate_rmse"), *BuiltinMetric("mme")}));
  EXPECT_FALSE(NeedsSharpness(DefaultMetrics()));
  SweepMetric own;  // a metric of the user's that happens to be called so
  own.name = "mme";
  own.pointer = "/x";
  EXPECT_FALSE(NeedsSharpness({own}));
}

}  // namespace
}  // namespace planegraph
