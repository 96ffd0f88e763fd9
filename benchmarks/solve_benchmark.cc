// Building and solving graphs of the size of a site, and their covariances. CPU time.
#include <benchmark/benchmark.h>

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

void Sizes(benchmark::internal::Benchmark* b) {
  b->Args({24, 8000})->Args({100, 8000})->Args({400, 8000})->Unit(benchmark::kMillisecond);
}

BENCHMARK_CAPTURE(SolveSite, dense_schur, LinearSolver::kDenseSchur, "moments")->Apply(Sizes);
BENCHMARK_CAPTURE(SolveSite, sparse_schur, LinearSolver::kSparseSchur, "moments")->Apply(Sizes);
BENCHMARK_CAPTURE(SolveSite, pose_pose, LinearSolver::kAuto, "pose_pose")->Apply(Sizes);
BENCHMARK(Covariances)->Apply(Sizes);

}  // namespace
}  // namespace planegraph
