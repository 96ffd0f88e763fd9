// One evaluation of every registered factor, with and without Jacobians.
#include <benchmark/benchmark.h>

#include <array>

#include "planegraph/graph/factor_registry.h"

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
