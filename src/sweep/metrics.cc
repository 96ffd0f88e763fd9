#include "sweep/metrics.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <functional>
#include <nlohmann/json.hpp>

#include "planegraph/base/atomic_file.h"
#include "planegraph/evaluation/statistics.h"
#include "sweep/json_pointer.h"

namespace planegraph {
namespace {

using Json = nlohmann::json;
using Value = std::optional<double>;

// All that is known of a run.
struct RunData {
  Json report, sharpness, truth;
  StageRecord record;
};

Json ReadJson(const std::string& path) {
  if (path.empty() || !std::filesystem::is_regular_file(path)) return nullptr;
  return Json::parse(ReadTextFile(path), nullptr, false);  // discarded: leads nowhere
}

Value NumberOf(const Json& node) {
  if (node.is_boolean()) return node.get<bool>() ? 1.0 : 0.0;
  if (!node.is_number() || !std::isfinite(node.get<double>())) return {};
  return node.get<double>();
}

std::vector<double> Numbers(const Json& root, const std::string& pointer) {
  std::vector<double> numbers;
  for (const Json& node : FollowPointer(root, pointer)) {
    if (const Value value = NumberOf(node)) numbers.push_back(*value);
  }
  return numbers;
}

Value First(const Json& root, const std::string& pointer) {
  const std::vector<double> numbers = Numbers(root, pointer);
  return numbers.empty() ? Value() : numbers.front();
}

double Count(const Json& root, const std::string& pointer) {
  const std::vector<Json> nodes = FollowPointer(root, pointer);
  return static_cast<double>(
      std::count_if(nodes.begin(), nodes.end(), [](const Json& node) { return !node.is_null(); }));
}

Value Reduced(const Json& root, const SweepMetric& metric) {
  if (!root.is_object()) return {};
  if (metric.aggregate == Aggregate::kCount) return Count(root, metric.pointer);
  const std::vector<double> numbers = Numbers(root, metric.pointer);
  if (numbers.empty()) return {};
  const Statistics statistics = Summarize(numbers);
  switch (metric.aggregate) {
    case Aggregate::kMedian:
      return statistics.median;
    case Aggregate::kMax:
      return statistics.max;
    case Aggregate::kMin:
      return statistics.min;
    case Aggregate::kSum:
      return statistics.mean * static_cast<double>(numbers.size());
    default:
      return statistics.mean;
  }
}

// The share of the scans that a drone map holds; nothing where the site has no map.
Value Anchored(const RunData& run) {
  const double scans = Count(run.report, "/scans/*");
  if (scans == 0.0 || Count(run.report, "/maps/*") == 0.0) return {};
  return Count(run.report, "/scans/*/anchored_to/0") / scans;
}

// The mean relative error of the drone maps' scales.
Value ScaleError(const RunData& run) {
  const Value truth = First(run.truth, "/scale");
  const std::vector<double> scales = Numbers(run.report, "/maps/*/world_from_map/scale");
  if (!truth || *truth == 0.0 || scales.empty()) return {};
  double sum = 0.0;
  for (double scale : scales) sum += std::abs(scale / *truth - 1.0);
  return sum / static_cast<double>(scales.size());
}

// Root of the cost by redundancy: 1 where the residuals are as large as their sigmas say.
Value Residual(const RunData& run) {
  const Value cost = First(run.report, "/solve/final_cost");
  const Value redundancy = First(run.report, "/solve/redundancy");
  if (!cost || !redundancy || *cost < 0.0 || *redundancy <= 0.0) return {};
  return std::sqrt(2.0 * *cost / *redundancy);
}

struct Builtin {
  SweepMetric metric;
  std::function<Value(const RunData&)> measure;  ///< none: by the metric's pointer
  bool is_default = true, needs_sharpness = false;
};

const std::vector<Builtin>& Builtins() {
  static const auto sharpness = [](const char* pointer) {
    return [pointer](const RunData& run) { return First(run.sharpness, pointer); };
  };
  static const std::vector<Builtin> builtins = {
      {{"ate_rmse", "m", "/evaluation/*/ate/rmse"}, nullptr},
      {{"rpe_translation", "m", "/evaluation/*/rpe/rmse"}, nullptr},
      {{"rpe_rotation", "rad", "/evaluation/*/rpe/rotation/rmse"}, nullptr},
      {{"anchored", "share of scans", ""}, Anchored},
      {{"scale_error", "relative", ""}, ScaleError},
      {{"residual", "sigma", ""}, Residual},
      {{"mme", "nat", ""}, sharpness("/mme"), false, true},
      {{"thickness", "m", ""}, sharpness("/thickness/median"), false, true},
      {{"cpu_seconds", "s", "", Aggregate::kMean, true},
       [](const RunData& run) { return run.record.cpu_seconds; }},
      {{"wall_seconds", "s", "", Aggregate::kMean, true},
       [](const RunData& run) { return run.record.wall_seconds; },
       false},
      {{"peak_memory", "bytes", "", Aggregate::kMean, true},
       [](const RunData& run) { return run.record.peak_memory_bytes; },
       false},
  };
  return builtins;
}

const Builtin* Find(const std::string& name) {
  for (const Builtin& builtin : Builtins()) {
    if (builtin.metric.name == name) return &builtin;
  }
  return nullptr;
}

}  // namespace

std::optional<SweepMetric> BuiltinMetric(const std::string& name) {
  const Builtin* builtin = Find(name);
  return builtin ? std::optional<SweepMetric>(builtin->metric) : std::nullopt;
}

std::string BuiltinMetricNames() {
  std::string names;
  for (const Builtin& builtin : Builtins()) {
    names += (names.empty() ? "" : ", ") + builtin.metric.name;
  }
  return names;
}

std::vector<SweepMetric> DefaultMetrics() {
  std::vector<SweepMetric> metrics;
  for (const Builtin& builtin : Builtins()) {
    if (builtin.is_default) metrics.push_back(builtin.metric);
  }
  return metrics;
}

std::optional<Aggregate> ParseAggregate(const std::string& name) {
  static const std::map<std::string, Aggregate> names = {
      {"mean", Aggregate::kMean}, {"median", Aggregate::kMedian}, {"max", Aggregate::kMax},
      {"min", Aggregate::kMin},   {"sum", Aggregate::kSum},       {"count", Aggregate::kCount}};
  const auto found = names.find(name);
  return found == names.end() ? std::nullopt : std::optional<Aggregate>(found->second);
}

std::string PointerError(const std::string& pointer) {
  if (pointer.empty() || pointer[0] != '/') return "a JSON pointer begins with a slash";
  for (std::size_t i = 0; i < pointer.size(); ++i) {
    const bool good = i + 1 < pointer.size() && (pointer[i + 1] == '0' || pointer[i + 1] == '1');
    if (pointer[i] == '~' && !good) return "after a tilde a JSON pointer has 0 or 1";
  }
  return "";
}

bool NeedsSharpness(const std::vector<SweepMetric>& metrics) {
  return std::any_of(metrics.begin(), metrics.end(), [](const SweepMetric& metric) {
    const Builtin* builtin = metric.pointer.empty() ? Find(metric.name) : nullptr;
    return builtin && builtin->needs_sharpness;
  });
}

std::vector<Value> Measure(const std::vector<SweepMetric>& metrics, const RunFiles& files,
                           const StageRecord& record) {
  RunData run;
  run.record = record;
  run.report = ReadJson(files.folder + "/report.json");
  run.sharpness = ReadJson(files.folder + "/evaluate.json");
  run.truth = ReadJson(files.truth);
  std::vector<Value> values;
  for (const SweepMetric& metric : metrics) {
    const Builtin* builtin = metric.pointer.empty() ? Find(metric.name) : nullptr;
    values.push_back(builtin && builtin->measure ? builtin->measure(run)
                                                 : Reduced(run.report, metric));
  }
  return values;
}

}  // namespace planegraph
