// Building and solving graphs of the size of a site, and their covariances. CPU time.
#include <benchmark/benchmark.h>
#include <sys/resource.h>

#include <algorithm>

#include "planegraph/geometry/rotation.h"
#include "planegraph/simulation/random.h"
#include "planegraph/solve/covariance.h"
#include "planegraph/solve/solver.h"
#include "solve/plane_world.h"

namespace planegraph {
namespace {

// About 4 observations per plane, by random poses: every pair of poses shares planes, so that the
// reduced system of the poses is dense. That is the hardest case; in a walk through a site it is
// sparse.
Graph Site(int poses, int planes) {
  PlaneWorld world({.poses = poses, .planes = planes, .seen_share = 4.0 / poses, .noise = 1.0});
  return world.Disturbed(0.03, 0.01);
}

void SolveSite(benchmark::State& state, LinearSolver solver, const char* factor) {
  const Graph start = Site(static_cast<int>(state.range(0)), static_cast<int>(state.range(1)));
  SolveOptions options;
  options.linear_solver = solver;
  options.plane_factor = factor;
  SolveSummary summary;
  for (auto _ : state) {
    Graph graph = start;
    summary = Solve(&graph, options);
  }
  state.counters["iterations"] = summary.iterations;
  state.counters["residuals"] = static_cast<double>(summary.residuals.size());
}

void Covariances(benchmark::State& state) {
  const Graph graph = Site(static_cast<int>(state.range(0)), static_cast<int>(state.range(1)));
  for (auto _ : state) {
    const GraphCovariance covariance(graph);
    for (int i = 0; i < state.range(0); ++i) benchmark::DoNotOptimize(covariance.Pose(i));
  }
}

PlaneObservation Seen(const Graph& graph, const PlaneLandmark& plane, int pose, Random* random) {
  const Rigid3 node_from_world = graph.poses[pose].world_from_node.Inverse();
  const auto basis = TangentBasis(plane.normal);
  Eigen::Matrix3d axes;
  axes << plane.normal, basis;
  PlaneObservation seen;
  seen.pose = pose;
  seen.tilt_weight_1 = seen.tilt_weight_2 = 300.0;
  seen.offset_weight = 200.0;
  seen.axes = node_from_world.rotation.toRotationMatrix() * axes;
  seen.centroid = node_from_world *
                  (plane.anchor + basis * Eigen::Vector2d(random->Normal(), random->Normal()));
  return seen;
}

// A walk in rows of 100 poses: each plane is seen by four scans in turn, one in ten also from the
// next row.
Graph Walk(int poses) {
  constexpr int kRow = 100, kPlanesPerPose = 8;
  Random random(1, 1);
  Graph graph;
  for (int i = 0; i < poses; ++i) {
    const int row = i / kRow, column = row % 2 == 0 ? i % kRow : kRow - 1 - i % kRow;
    graph.poses.push_back(
        {std::to_string(i), Rigid3(ExpSO3({0, 0, 0.1 * i}), {1.0 * column, 3.0 * row, 0}), i == 0});
  }
  for (int k = 0; k < poses * kPlanesPerPose; ++k) {
    const int first = k / kPlanesPerPose;
    PlaneLandmark plane;
    plane.normal = Eigen::Vector3d(random.Normal(), random.Normal(), random.Normal());
    plane.normal.normalize();
    plane.anchor = graph.poses[first].world_from_node.translation + 4.0 * plane.normal;
    for (int i = first; i < std::min(first + 4, poses); ++i) {
      plane.observations.push_back(Seen(graph, plane, i, &random));
    }
    const int across = first + 2 * (kRow - 1 - first % kRow) + 1;
    if (k % 10 == 0 && across >= first + 4 && across < poses) {
      plane.observations.push_back(Seen(graph, plane, across, &random));
    }
    if (plane.observations.size() > 1) graph.planes.push_back(std::move(plane));
  }
  return graph;
}

// Of all poses, of steps from each to the next, and of all planes, by selected inversion.
void CovariancesOfAWalk(benchmark::State& state) {
  const Graph graph = Walk(static_cast<int>(state.range(0)));
  for (auto _ : state) {
    const GraphCovariance covariance(graph);
    for (int i = 1; i < state.range(0); ++i) {
      benchmark::DoNotOptimize(covariance.Pose(i));
      benchmark::DoNotOptimize(covariance.Relative(i - 1, i));
    }
    for (std::size_t k = 0; k < graph.planes.size(); ++k) {
      benchmark::DoNotOptimize(covariance.Plane(static_cast<int>(k)));
    }
  }
  rusage usage{};
  ::getrusage(RUSAGE_SELF, &usage);
  state.counters["planes"] = static_cast<double>(graph.planes.size());
  state.counters["peak_MB"] = static_cast<double>(usage.ru_maxrss) / 1024.0;
}

void Sizes(benchmark::internal::Benchmark* b) {
  b->Args({24, 8000})->Args({100, 8000})->Args({400, 8000})->Unit(benchmark::kMillisecond);
}

BENCHMARK_CAPTURE(SolveSite, dense_schur, LinearSolver::kDenseSchur, "moments")->Apply(Sizes);
BENCHMARK_CAPTURE(SolveSite, sparse_schur, LinearSolver::kSparseSchur, "moments")->Apply(Sizes);
BENCHMARK_CAPTURE(SolveSite, pose_pose, LinearSolver::kAuto, "pose_pose")->Apply(Sizes);
BENCHMARK(Covariances)->Apply(Sizes);
BENCHMARK(CovariancesOfAWalk)->Arg(100)->Arg(1000)->Arg(10000)->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace planegraph
