// Matching two scans of 30 planes each without a guess, and what comes before and after.
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
  ScanPair() {
    SimulationOptions options;
    options.scene = SceneKind::kHall;
    options.scans = 12;
    const SimulatedSite site = Simulate(options);
    target = KeepLargest(SegmentPlanes(site.robots[0].scans[1].cloud).planes, kPlanes);
    source = KeepLargest(SegmentPlanes(site.robots[0].scans[2].cloud).planes, kPlanes);
  }
};

const ScanPair& Pair() {
  static const ScanPair pair;
  return pair;
}

void CountPlanes(benchmark::State& state) {
  state.counters["target_planes"] = static_cast<double>(Pair().target.planes.size());
  state.counters["source_planes"] = static_cast<double>(Pair().source.planes.size());
}

void MakeScanModel(benchmark::State& state) {
  for (auto _ : state) benchmark::DoNotOptimize(ScanModel(Pair().source));
  CountPlanes(state);
}
BENCHMARK(MakeScanModel)->Unit(benchmark::kMillisecond);

void MatchWithoutGuess(benchmark::State& state) {
  const ScanModel target(Pair().target), source(Pair().source);
  for (auto _ : state) benchmark::DoNotOptimize(FindHypotheses(target, source));
  CountPlanes(state);
}
BENCHMARK(MatchWithoutGuess)->Unit(benchmark::kMillisecond);

void RegisterWithoutGuess(benchmark::State& state) {
  const ScanModel target(Pair().target), source(Pair().source);
  for (auto _ : state) benchmark::DoNotOptimize(Register(target, source));
  CountPlanes(state);
}
BENCHMARK(RegisterWithoutGuess)->Unit(benchmark::kMillisecond);

// The paper's search and closed form on the same planes.
void RegisterByXiao(benchmark::State& state) {
  for (auto _ : state) benchmark::DoNotOptimize(RegisterXiao(Pair().target, Pair().source));
  CountPlanes(state);
}
BENCHMARK(RegisterByXiao)->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace planegraph
