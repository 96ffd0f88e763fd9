// initialization_table [SITES_PER_SCENE [FIRST_SEED [SCENE]]]: how often a graph of simulated scans
// finds its poses from no guess at all, by the share of observations that are assigned to a wrong
// landmark: the joint closed form, the solver from there, and the solver from odometry. Markdown;
// CPU seconds of the thread.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <random>
#include <string>
#include <vector>

#include "planegraph/base/angles.h"
#include "planegraph/base/median.h"
#include "planegraph/geometry/rotation.h"
#include "planegraph/segmentation/segmenter.h"
#include "planegraph/simulation/simulation.h"
#include "planegraph/solve/association.h"
#include "planegraph/solve/joint_initialization.h"
#include "planegraph/solve/solver.h"
#include "solve/mismatched_graph.h"
#include "thread_seconds.h"

namespace planegraph {
namespace {

constexpr double kMostMetres = 0.2, kMostRadians = kDegree;  // of a success: rmse, largest
const std::vector<double> kWrongShares = {0.0, 0.37, 0.6};
const std::vector<std::string> kLosses = {"none", "cauchy", "gnc_tls"};

// A site as the solver gets it, where all correspondences are right.
struct KnownSite {
  std::vector<Rigid3> truth, odometry;  // both in the frame of the first scan
  Graph graph;
};

KnownSite MakeSite(SceneKind scene, std::uint64_t seed) {
  SimulationOptions options;
  options.scene = scene;
  options.seed = seed;
  options.drone_mode = DroneMode::kOff;
  const SimulatedSite site = Simulate(options);
  const SimulatedRobot& robot = site.robots.front();
  std::vector<PlaneSet> planes;
  for (const LabelledScan& scan : robot.scans) planes.push_back(SegmentPlanes(scan.cloud).planes);
  KnownSite known;
  std::vector<const PlaneSet*> seen;
  for (std::size_t i = 0; i < planes.size(); ++i) {
    seen.push_back(&planes[i]);
    known.truth.push_back(robot.truth.front().Inverse() * robot.truth[i]);
    known.odometry.push_back(robot.odometry.front().Inverse() * robot.odometry[i]);
    known.graph.poses.push_back({std::to_string(i), known.truth.back(), i == 0});
  }
  // The floors that the segmentation states for whole planes, as nothing is measured here.
  AssociationOptions association;
  association.floor_offset = SegmentationOptions().floor_offset;
  association.floor_tilt = SegmentationOptions().floor_tilt_deg * kDegree;
  known.graph.planes = AssociatePatches(seen, known.truth, association);
  return known;
}

// Planes as the poses have them.
void FitPlanes(Graph* graph) {
  for (PlaneLandmark& plane : graph->planes) {
    plane = MakePlaneLandmark(*graph, plane.observations);
    FitLandmark(*graph, &plane);
  }
}

bool IsFound(const Graph& graph, const std::vector<Rigid3>& truth) {
  double sum = 0.0, largest = 0.0;
  for (std::size_t i = 0; i < truth.size(); ++i) {
    const Rigid3& pose = graph.poses[i].world_from_node;
    sum += (pose.translation - truth[i].translation).squaredNorm();
    largest = std::max(largest, AngleBetween(pose.rotation, truth[i].rotation));
  }
  return std::sqrt(sum / static_cast<double>(truth.size())) < kMostMetres && largest < kMostRadians;
}

bool FoundBySolver(Graph graph, const std::string& loss, const std::vector<Rigid3>& truth) {
  SolveOptions options;
  options.plane_loss = ParseLoss(loss);
  Solve(&graph, options);
  return IsFound(graph, truth);
}

struct Counts {
  int sites = 0, started = 0;
  std::vector<int> from_start, from_odometry;  // by loss
  std::vector<double> seconds;
};

void Try(const KnownSite& site, double share, std::uint64_t seed, Counts* counts) {
  std::mt19937_64 rng(seed);
  Graph graph = site.graph;
  MismatchObservations(share, &rng, &graph);
  Graph from_odometry = graph;
  for (std::size_t i = 0; i < site.odometry.size(); ++i) {
    from_odometry.poses[i].world_from_node = site.odometry[i];
  }
  FitPlanes(&from_odometry);
  ScatterPoses(30.0, &rng, &graph);
  const double start = ThreadSeconds();
  InitializeJointly(&graph);
  counts->seconds.push_back(ThreadSeconds() - start);
  ++counts->sites;
  counts->started += IsFound(graph, site.truth);
  counts->from_start.resize(kLosses.size());
  counts->from_odometry.resize(kLosses.size());
  for (std::size_t l = 0; l < kLosses.size(); ++l) {
    counts->from_start[l] += FoundBySolver(graph, kLosses[l], site.truth);
    counts->from_odometry[l] += FoundBySolver(from_odometry, kLosses[l], site.truth);
  }
}

void PrintHeader() {
  std::printf("| scene | wrong | sites | joint start |");
  for (const std::string& loss : kLosses) std::printf(" then %s |", loss.c_str());
  for (const std::string& loss : kLosses) std::printf(" odometry, %s |", loss.c_str());
  std::printf(" CPU s of the start |\n|---|---|---|---|");
  for (std::size_t i = 0; i < 2 * kLosses.size(); ++i) std::printf("---|");
  std::printf("---|\n");
}

void PrintRow(const std::string& scene, double share, const Counts& counts) {
  std::printf("| %s | %.0f %% | %d | %d |", scene.c_str(), 100.0 * share, counts.sites,
              counts.started);
  for (int count : counts.from_start) std::printf(" %d |", count);
  for (int count : counts.from_odometry) std::printf(" %d |", count);
  std::printf(" %.2f |\n", Median(counts.seconds));
}

void PrintScene(const std::string& scene, int sites, std::uint64_t first_seed) {
  std::vector<Counts> counts(kWrongShares.size());
  for (int k = 0; k < sites; ++k) {
    const std::uint64_t seed = first_seed + static_cast<std::uint64_t>(k);
    const KnownSite site = MakeSite(ParseSceneKind(scene), seed);
    for (std::size_t w = 0; w < kWrongShares.size(); ++w) {
      Try(site, kWrongShares[w], seed, &counts[w]);
    }
  }
  for (std::size_t w = 0; w < kWrongShares.size(); ++w) PrintRow(scene, kWrongShares[w], counts[w]);
}

}  // namespace
}  // namespace planegraph

int main(int argc, char** argv) {
  const int sites = argc > 1 ? std::atoi(argv[1]) : 50;
  const std::uint64_t first_seed = argc > 2 ? std::strtoull(argv[2], nullptr, 10) : 1;
  planegraph::PrintHeader();
  std::vector<std::string> scenes = {"hall", "yard"};
  if (argc > 3) scenes = {argv[3]};
  for (const std::string& scene : scenes) planegraph::PrintScene(scene, sites, first_seed);
  return 0;
}
