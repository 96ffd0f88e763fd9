// One evaluation of every registered factor, with and without Jacobians.
#include <benchmark/benchmark.h>

#include <array>

#include "planegraph/graph/factor_registry.h"
#include "planegraph/graph/factor_sampling.h"
#include "planegraph/solve/solver.h"

namespace planegraph {
namespace {

void Evaluate(benchmark::State& state, const FactorType& type, bool with_jacobians) {
  std::mt19937_64 rng(1);
  const FactorSample sample = type.sample(&rng);
  std::vector<const double*> blocks;
  for (const auto& value : sample.values) blocks.push_back(value.data());
  std::array<double, 16> residuals;
  std::vector<std::array<double, 16 * 8>> storage(sample.values.size());
  std::vector<double*> jacobians;
  for (auto& jacobian : storage) jacobians.push_back(jacobian.data());
  for (auto _ : state) {
    sample.cost->Evaluate(blocks.data(), residuals.data(),
                          with_jacobians ? jacobians.data() : nullptr);
    benchmark::DoNotOptimize(residuals);
    benchmark::ClobberMemory();
  }
}

// An observation of that many points against its landmark: the moments' cost does not grow.
void EvaluatePoints(benchmark::State& state, const std::string& factor) {
  std::mt19937_64 rng(1);
  FactorSampler sampler(&rng);
  Moments moments;
  auto points = std::make_shared<std::vector<Eigen::Vector3d>>();
  for (std::int64_t k = 0; k < state.range(0); ++k) {
    const Eigen::Vector3d point(sampler.Uniform(-2, 2), sampler.Uniform(-2, 2), 0.0);
    moments.Add(point);
    if (factor == "raw_points") points->push_back(point);
  }
  Graph graph;
  graph.poses.resize(1);
  graph.planes.resize(1);
  PlaneObservation seen;
  seen.centroid = moments.mean;
  seen.axes = ComputePrincipalAxes(moments.scatter).vectors;
  seen.points = points;
  graph.planes[0].observations = {seen, seen};
  for (auto _ : state) {
    Graph work = graph;
    SolveOptions options;
    options.plane_factor = factor;
    options.max_iterations = 1;
    benchmark::DoNotOptimize(Solve(&work, options));
  }
}
BENCHMARK_CAPTURE(EvaluatePoints, moments, "moments")->RangeMultiplier(10)->Range(1000, 10000000);
BENCHMARK_CAPTURE(EvaluatePoints, raw, "raw_points")->RangeMultiplier(10)->Range(1000, 1000000);

[[maybe_unused]] const bool registered = [] {
  for (const auto& [name, type] : BuiltinFactors().types()) {
    for (const bool with_jacobians : {false, true}) {
      const std::string label = name + (with_jacobians ? "/jacobians" : "/residuals");
      benchmark::RegisterBenchmark(label.c_str(), [&type = type, with_jacobians](auto& state) {
        Evaluate(state, type, with_jacobians);
      });
    }
  }
  return true;
}();

}  // namespace
}  // namespace planegraph
