// Matching two scans of 30 planes each without a guess, and what comes before and after: the 30
// largest planes of two simulated scans of a hall (whose second scan has only 28) and of a yard.
#include <benchmark/benchmark.h>

#include <algorithm>
#include <numeric>

#include "planegraph/registration/registration.h"
#include "planegraph/registration/xiao.h"
#include "planegraph/segmentation/segmenter.h"
#include "planegraph/simulation/simulation.h"

namespace planegraph {
namespace {

constexpr std::size_t kPlanes = 30;

// The planes of largest area, with their patches alone.
PlaneSet KeepLargest(PlaneSet set, std::size_t count) {
  std::vector<std::int32_t> order(set.planes.size());
  std::iota(order.begin(), order.end(), 0);
  std::stable_sort(order.begin(), order.end(), [&](std::int32_t a, std::int32_t b) {
    return set.planes[a].area > set.planes[b].area;
  });
  order.resize(std::min(count, order.size()));
  std::vector<std::int32_t> new_place(set.planes.size(), -1);
  std::vector<PlaneSegment> planes;
  for (const std::int32_t p : order) {
    new_place[p] = static_cast<std::int32_t>(planes.size());
    planes.push_back(set.planes[p]);
  }
  std::erase_if(set.patches, [&](const Patch& patch) {
    return patch.segment < 0 || new_place[patch.segment] < 0;
  });
  for (Patch& patch : set.patches) patch.segment = new_place[patch.segment];
  set.planes = std::move(planes);
  return set;
}

struct ScanPair {
  PlaneSet target, source;
  explicit ScanPair(SceneKind scene) {
    SimulationOptions options;
    options.scene = scene;
    options.scans = 12;
    const SimulatedSite site = Simulate(options);
    target = KeepLargest(SegmentPlanes(site.robots[0].scans[1].cloud).planes, kPlanes);
    source = KeepLargest(SegmentPlanes(site.robots[0].scans[2].cloud).planes, kPlanes);
  }
};

// By the benchmark's argument: 0 hall, 1 yard.
const ScanPair& Pair(const benchmark::State& state) {
  static const ScanPair hall(SceneKind::kHall), yard(SceneKind::kYard);
  return state.range(0) == 0 ? hall : yard;
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
  for (auto _ : state) benchmark::DoNotOptimize(ScanModel(Pair(state).source));
  CountPlanes(0.0, &state);
}
BENCHMARK(MakeScanModel)->Arg(0)->Arg(1)->Unit(benchmark::kMillisecond);

void MatchWithoutGuess(benchmark::State& state) {
  const ScanModel target(Pair(state).target), source(Pair(state).source);
  for (auto _ : state) benchmark::DoNotOptimize(FindHypotheses(target, source));
  CountPlanes(0.0, &state);
}
BENCHMARK(MatchWithoutGuess)->Arg(0)->Arg(1)->Unit(benchmark::kMillisecond);

void RegisterWithoutGuess(benchmark::State& state) {
  const ScanModel target(Pair(state).target), source(Pair(state).source);
  for (auto _ : state) benchmark::DoNotOptimize(Register(target, source));
  CountPlanes(0.0, &state);
}
BENCHMARK(RegisterWithoutGuess)->Arg(0)->Arg(1)->Unit(benchmark::kMillisecond);

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
BENCHMARK(RegisterByXiao)->Arg(0)->Arg(1)->Unit(benchmark::kMillisecond);

void RegisterByXiaoWithAllPlanes(benchmark::State& state) {
  XiaoOptions options;
  options.min_area = 0.0;
  RunXiao(options, &state);
}
BENCHMARK(RegisterByXiaoWithAllPlanes)->Arg(0)->Arg(1)->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace planegraph
