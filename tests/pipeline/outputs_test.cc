#include "planegraph/pipeline/outputs.h"

#include <gmock/gmock.h>

#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <set>

#include "pipeline/small_site.h"
#include "planegraph/evaluation/scan_merge.h"
#include "planegraph/geometry/rotation.h"
#include "planegraph/io/g2o_io.h"
#include "planegraph/solve/marginal_graph.h"
#include "planegraph/solve/solver.h"

namespace planegraph {
namespace {

namespace fs = std::filesystem;

class Outputs : public TestFolder {
 protected:
  Outputs() { WriteSite(Path("site"), SmallSite(SceneKind::kHall, 3, 16)); }
  Site ReadBack() const { return ReadSite(Path("site/site.yaml")); }
  MapResult Run(const std::string& out, const Site& site, const std::string& optimizer = "graph") {
    const MapResult result = MapScans(site, TwoThreads(optimizer));
    WriteOutputs(result, {Path(out), 0.05, 2});
    return result;
  }
};

// All files below a folder, by their names relative to it.
std::map<std::string, std::string> FilesOf(const std::string& folder) {
  std::map<std::string, std::string> files;
  for (const auto& entry : fs::recursive_directory_iterator(folder)) {
    if (!entry.is_regular_file()) continue;
    files[fs::relative(entry.path(), folder).string()] = ReadTextFile(entry.path().string());
  }
  return files;
}

TEST_F(Outputs, TwoRunsGiveTheSameBytes) {
  const Site site = ReadBack();
  Run("one", site);
  Run("two", site);
  const auto one = FilesOf(Path("one")), two = FilesOf(Path("two"));
  ASSERT_EQ(one.size(), 9u);  // trajectory, graph, map, and frames and planes of three scans
  for (const char* name : {"trajectory_robot1.tum", "graph.g2o", "map.ply",
                           "frames/robot1/scan002.frames", "planes/robot1_002.json"}) {
    EXPECT_EQ(one.count(name), 1u) << name;
  }
  for (const auto& [name, bytes] : one) EXPECT_TRUE(two.at(name) == bytes) << name;
}

TEST_F(Outputs, TrajectoriesAgree) {
  const SimulatedSite hall = SmallSite(SceneKind::kHall, 3, 16);
  const MapResult result = Run("out", ReadBack(), "none");
  const Trajectory tum = ReadTrajectory(Path("out/trajectory_robot1.tum"));
  const Trajectory frames = ReadTrajectory(Path("out/frames/robot1"));
  ASSERT_EQ(tum.size(), 3u);
  ASSERT_EQ(frames.size(), 3u);
  for (std::size_t i = 0; i < 3; ++i) {
    EXPECT_EQ(tum.times[i], hall.robots[0].times[i]);
    EXPECT_EQ(tum.poses[i].translation, result.solution.world_from_scan[i].translation);
    EXPECT_LT((frames.poses[i].translation - tum.poses[i].translation).norm(), 1e-9);
    EXPECT_LT(AngleBetween(frames.poses[i].rotation, tum.poses[i].rotation), 1e-9);
  }
}

Graph GraphOf(const G2oGraph& file) {
  Graph graph;
  std::map<long long, int> index;
  const std::set<long long> fixed(file.fixed.begin(), file.fixed.end());
  for (const auto& vertex : file.vertices3) {
    index[vertex.id] = static_cast<int>(graph.poses.size());
    graph.poses.push_back({std::to_string(vertex.id), vertex.pose, fixed.count(vertex.id) > 0});
  }
  for (const auto& edge : file.edges3) {
    graph.pose_factors.push_back(
        MakeRelativePose(index.at(edge.from), index.at(edge.to), edge.measurement,
                         InformationFromG2o(edge.measurement, edge.information), "file"));
  }
  return graph;
}

TEST_F(Outputs, TheGraphFilesPosesAreItsOptimum) {
  Run("out", ReadBack());
  const G2oGraph file = ReadG2o(Path("out/graph.g2o"));
  ASSERT_EQ(file.vertices3.size(), 3u);
  ASSERT_GE(file.edges3.size(), 2u);
  ASSERT_EQ(file.fixed.size(), 1u);
  Graph graph = GraphOf(file);
  for (std::size_t i = 0; i < graph.poses.size(); ++i) {
    if (graph.poses[i].fixed) continue;
    Rigid3& pose = graph.poses[i].world_from_node;
    pose.translation += Eigen::Vector3d(0.02, -0.01, 0.03);
    pose.rotation = ExpSO3({0.01, 0.02, -0.01}) * pose.rotation;
  }
  EXPECT_TRUE(Solve(&graph).converged);
  for (std::size_t i = 0; i < graph.poses.size(); ++i) {
    const Rigid3& solved = graph.poses[i].world_from_node;
    EXPECT_LT((solved.translation - file.vertices3[i].pose.translation).norm(), 1e-6);
    EXPECT_LT(AngleBetween(solved.rotation, file.vertices3[i].pose.rotation), 1e-6);
  }
}

TEST_F(Outputs, TheMapHoldsTheScansUnderTheirPoses) {
  const SimulatedSite hall = SmallSite(SceneKind::kHall, 3, 16);
  const MapResult result = Run("out", ReadBack());
  const Cloud map = ReadCloud(Path("out/map.ply"));
  std::size_t k = 0;
  for (std::size_t i = 0; i < 3; ++i) {
    const Cloud scan = RangeFilter(hall.robots[0].scans[i].cloud, 0.5, INFINITY);
    for (const std::uint32_t p : FirstOfEachVoxel(scan, 0.05)) {
      ASSERT_LT(k, map.size());
      const Eigen::Vector3d expected = result.solution.world_from_scan[i] * scan.Position(p);
      ASSERT_LT((map.Position(k++) - expected).norm(), 1e-4);
    }
  }
  EXPECT_EQ(k, map.size());
  EXPECT_EQ(map.colors.size(), map.size());
}

TEST_F(Outputs, TheMapGoesThroughTheSitesFilters) {
  Write("site/filtered.yaml", R"(robots:
  - name: robot1
    scans: scans/scan*.ply
    odometry: odometry.tum
    filters: [{range: {min: 1, max: 12}}, {voxel: {size: 0.08, centroid: 0}}]
)");
  const MapResult result = Run("out", ReadSite(Path("site/filtered.yaml")));
  EXPECT_EQ(result.components, 1);
  const Cloud map = ReadCloud(Path("out/map.ply"));
  std::size_t filtered = 0;
  for (const auto& scan : result.scans) {
    EXPECT_LT(scan.points_filtered, scan.points);
    filtered += scan.points_filtered;
  }
  EXPECT_LE(map.size(), filtered);
  EXPECT_GT(map.size(), filtered / 2);
  for (std::size_t i = 0; i < map.size(); ++i) {
    double nearest = INFINITY;
    for (const auto& pose : result.solution.world_from_scan) {
      const double range = (map.Position(i) - pose.translation).norm();
      if (range > 0.999) nearest = std::min(nearest, range);
    }
    ASSERT_LE(nearest, 12.001);
  }
}

TEST_F(Outputs, AllPointsWithoutAVoxel) {
  const MapResult result = MapScans(ReadBack(), TwoThreads("none"));
  WriteOutputs(result, {Path("out"), 0.0, 2});
  std::size_t points = 0;
  for (const auto& scan : result.scans) points += scan.points_filtered;
  EXPECT_EQ(ReadCloud(Path("out/map.ply")).size(), points);
}

TEST_F(Outputs, AFolderThatCannotBe) {
  const MapResult result = MapScans(ReadBack(), TwoThreads("none"));
  EXPECT_THROW(WriteOutputs(result, {"/proc/nowhere", 0.05, 2}), InputError);
}

TEST_F(Outputs, TheReportSaysWhatTheRunFound) {
  const Site site = ReadBack();
  const MapResult result = MapScans(site, TwoThreads());
  const auto report = nlohmann::json::parse(ReportJson(result, TwoThreads()));
  EXPECT_EQ(report["components"], 1);
  ASSERT_EQ(report["scans"].size(), 3u);
  EXPECT_EQ(report["scans"][2]["id"], "robot1/002");
  EXPECT_EQ(report["scans"][0]["covariance"].size(), 6u);
  EXPECT_EQ(report["registrations"].size(), result.pairs.size());
  EXPECT_EQ(report["registrations"][0]["target"], "robot1/000");
  EXPECT_EQ(report["solve"]["optimizer"], "graph");
  const auto& evaluation = report["evaluation"]["robot1"];
  EXPECT_LT(evaluation["ate"]["rmse"], 0.005);
  EXPECT_EQ(evaluation["rpe"]["count"], 2);
}

// Every scan of a corridor slides along it: one line says so for all of them.
TEST_F(Outputs, TheReportNamesWhatManyScansShareOnce) {
  WriteSite(Path("corridor"), SmallSite(SceneKind::kCorridor, 3, 8));
  const Site site = ReadSite(Path("corridor/site.yaml"));
  const MapResult result = MapScans(site, TwoThreads());
  const auto report = nlohmann::json::parse(ReportJson(result, TwoThreads()));
  const auto& motions = report["observability"]["motions"];
  ASSERT_EQ(motions.size(), 1u);
  EXPECT_EQ(motions[0]["kind"], "translation");
  EXPECT_NEAR(std::abs(motions[0]["directions"][0][0].get<double>()), 1.0, 0.01);
  EXPECT_EQ(motions[0]["parts"].size(), 3u);
  EXPECT_EQ(motions[0]["held_by"], "odometry");
  EXPECT_EQ(report["observability"]["open_degrees_of_freedom"], 2);
  EXPECT_THAT(motions[0]["text"].get<std::string>(),
              testing::ContainsRegex("not observed by planes for 3 scans, each by itself, sigma "
                                     "[0-9.]+ m from odometry"));
  const MapResult bare = MapScans(site, TwoThreads("none"));
  EXPECT_TRUE(
      nlohmann::json::parse(ReportJson(bare, TwoThreads("none")))["observability"].is_null());
}

// Errors of relative poses do not depend on the frame in which the truth is given.
TEST_F(Outputs, TheConsistencyIsThatOfAnyFrameOfTheReference) {
  Site site = ReadBack();
  const MapResult result = MapScans(site, TwoThreads());
  const auto consistency = [&](const Site& with) {
    MapResult other = result;
    other.site = with;
    return nlohmann::json::parse(ReportJson(other, TwoThreads()))["reference"]["consistency"];
  };
  const auto here = consistency(site);
  EXPECT_EQ(here["count"], 2);
  EXPECT_EQ(here["degrees_of_freedom"], 12);
  EXPECT_EQ(here["joint"], true);
  EXPECT_GT(here["pose_nees"], 0.0);
  EXPECT_LT(here["pose_nees"], 5.0);
  EXPECT_EQ(here["robots"]["robot1"]["each"].size(), 2u);
  EXPECT_EQ(here["robots"]["robot1"]["relative_to"], "robot1/000");
  EXPECT_FALSE(here.contains("scale_nees"));
  Trajectory moved = ReadTrajectory(site.robots[0].reference);
  const Rigid3 motion(ExpSO3({0.3, -0.5, 2.0}), {3, -2, 5});
  for (Rigid3& pose : moved.poses) pose = motion * pose;
  WriteTum(Path("moved.tum"), moved);
  site.robots[0].reference = Path("moved.tum");
  const auto there = consistency(site);
  EXPECT_NEAR(there["pose_nees"], here["pose_nees"].get<double>(), 1e-3);
  EXPECT_EQ(there["coverage"], here["coverage"]);
  site.robots[0].reference.clear();
  EXPECT_TRUE(consistency(site).empty());
}

// The reference is for the evaluation alone: one that does not fit must not cost the results.
TEST_F(Outputs, AReferenceThatDoesNotFitIsAWarning) {
  Site site = ReadBack();
  site.robots[0].reference = Write("reference.tum", "9000 0 0 0 0 0 0 1\n9001 1 0 0 0 0 0 1\n");
  const MapResult result = MapScans(site, TwoThreads("none"));
  const auto report = nlohmann::json::parse(ReportJson(result, TwoThreads("none")));
  EXPECT_EQ(report["scans"].size(), 3u);
  EXPECT_EQ(report["warnings"].size(), 1u);
  EXPECT_TRUE(report["evaluation"].empty());
}

TEST_F(Outputs, AReferenceOfOnePoseHasNoSteps) {
  Site site = ReadBack();
  site.robots[0].reference = Write("reference.tum", "0 0 0 0 0 0 0 1\n");
  const MapResult result = MapScans(site, TwoThreads("none"));
  const auto report = nlohmann::json::parse(ReportJson(result, TwoThreads("none")));
  EXPECT_EQ(report["evaluation"]["robot1"]["ate"]["count"], 1);
  EXPECT_EQ(report["evaluation"]["robot1"].count("rpe"), 0u);
}

}  // namespace
}  // namespace planegraph
