// Matching two scans without a guess, and what comes before and after: the 30 largest planes of two
// simulated scans of a hall (whose second scan has only 28) and of a yard, and all of their planes.
#include <benchmark/benchmark.h>

#include <algorithm>
#include <map>

#include "plane_subset.h"
#include "planegraph/registration/registration.h"
#include "planegraph/registration/xiao.h"
#include "planegraph/segmentation/segmenter.h"
#include "planegraph/simulation/simulation.h"

namespace planegraph {
namespace {

struct ScanPair {
  PlaneSet target, source;
  ScanPair(SceneKind scene, std::size_t planes) {
    SimulationOptions options;
    options.scene = scene;
    options.scans = 12;
    const SimulatedSite site = Simulate(options);
    target = LargestPlanes(SegmentPlanes(site.robots[0].scans[1].cloud).planes, planes);
    source = LargestPlanes(SegmentPlanes(site.robots[0].scans[2].cloud).planes, planes);
  }
};

// By the benchmark's arguments: 0 hall, 1 yard; the number of planes.
const ScanPair& Pair(const benchmark::State& state) {
  static std::map<std::pair<std::int64_t, std::int64_t>, ScanPair> pairs;
  const std::int64_t scene = state.range(0), planes = state.range(1);
  return pairs
      .try_emplace({scene, planes}, scene == 0 ? SceneKind::kHall : SceneKind::kYard,
                   static_cast<std::size_t>(planes))
      .first->second;
}

void EachPair(benchmark::internal::Benchmark* benchmark) {
  constexpr std::int64_t kAll = 1000;
  benchmark->ArgNames({"yard", "planes"})->ArgsProduct({{0, 1}, {30, kAll}});
  benchmark->Unit(benchmark::kMillisecond);
}

// The planes that take part.
void CountPlanes(double min_area, benchmark::State* state) {
  const auto count = [&](const PlaneSet& set) {
    return static_cast<double>(
        std::count_if(set.planes.begin(), set.planes.end(),
                      [&](const PlaneSegment& plane) { return plane.area >= min_area; }));
  };
  state->counters["target_planes"] = count(Pair(*state).target);
  state->counters["source_planes"] = count(Pair(*state).source);
}

void MakeScanModel(benchmark::State& state) {
  const PlaneSet& source = Pair(state).source;
  for (auto _ : state) benchmark::DoNotOptimize(ScanModel(source));
  CountPlanes(0.0, &state);
}
BENCHMARK(MakeScanModel)->Apply(EachPair);

void MatchWithoutGuess(benchmark::State& state) {
  const ScanModel target(Pair(state).target), source(Pair(state).source);
  for (auto _ : state) benchmark::DoNotOptimize(FindHypotheses(target, source));
  CountPlanes(0.0, &state);
}
BENCHMARK(MatchWithoutGuess)->Apply(EachPair);

void RegisterWithoutGuess(benchmark::State& state) {
  const ScanModel target(Pair(state).target), source(Pair(state).source);
  for (auto _ : state) benchmark::DoNotOptimize(Register(target, source));
  CountPlanes(0.0, &state);
}
BENCHMARK(RegisterWithoutGuess)->Apply(EachPair);

// The paper's search and closed form on the same planes.
void RunXiao(const XiaoOptions& options, benchmark::State* state) {
  const ScanPair& pair = Pair(*state);
  for (auto _ : *state) {
    benchmark::DoNotOptimize(RegisterXiao(pair.target, pair.source, options));
  }
  CountPlanes(options.min_area, state);
  const XiaoMatch match = MatchXiao(pair.target, pair.source, options);
  state->counters["area_pairs"] = static_cast<double>(match.area_pairs);
  state->counters["grown"] = static_cast<double>(match.triplets);
}

void RegisterByXiao(benchmark::State& state) { RunXiao({}, &state); }
BENCHMARK(RegisterByXiao)->Apply(EachPair);

void RegisterByXiaoWithAllPlanes(benchmark::State& state) {
  XiaoOptions options;
  options.min_area = 0.0;
  RunXiao(options, &state);
}
BENCHMARK(RegisterByXiaoWithAllPlanes)->Apply(EachPair);

}  // namespace
}  // namespace planegraph
