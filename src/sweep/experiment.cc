#include "planegraph/sweep/experiment.h"

#include <algorithm>
#include <charconv>

#include "pipeline/yaml_reader.h"
#include "sweep/metrics.h"

namespace planegraph {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kMostRuns = 1000000;

class ExperimentReader : private YamlReader {
 public:
  ExperimentReader(const std::string& path, const fs::path& folder, FlagCheck check)
      : YamlReader(path, folder), check_(std::move(check)) {}

  Experiment Read();

 private:
  YAML::Node List(const YAML::Node& map, const std::string& key, bool needed) const;
  void CheckName(const YAML::Node& node, const std::string& name,
                 std::set<std::string>* taken) const;
  std::string Name(const YAML::Node& map, const std::string& kind,
                   std::set<std::string>* taken) const;
  void AddFlag(const YAML::Node& key, const YAML::Node& value, const std::string& command,
               FlagValues* flags) const;
  FlagValues Flags(const YAML::Node& node, const std::string& command) const;
  std::uint64_t Seed(const YAML::Node& node, std::string_view text) const;
  void AddSeeds(const YAML::Node& node, std::vector<std::uint64_t>* seeds) const;
  std::vector<std::uint64_t> Seeds(const YAML::Node& map,
                                   std::vector<std::uint64_t> fallback) const;
  SweepDataSet DataSet(const YAML::Node& node, const std::vector<std::uint64_t>& seeds,
                       std::set<std::string>* taken) const;
  SweepVariant Variant(const YAML::Node& node, std::set<std::string>* taken) const;
  std::vector<SweepVariant> Grid(const YAML::Node& node, std::set<std::string>* taken) const;
  std::vector<SweepVariant> Variants(const YAML::Node& root) const;
  SweepMetric OwnMetric(const YAML::Node& node) const;
  SweepMetric Metric(const YAML::Node& node) const;
  std::vector<SweepMetric> Metrics(const YAML::Node& root) const;
  std::size_t Baseline(const YAML::Node& root, const std::vector<SweepVariant>& variants) const;
  void Numbers(const YAML::Node& root, Experiment* experiment) const;
  void CheckSize(const YAML::Node& root, const Experiment& experiment) const;

  FlagCheck check_;
};

YAML::Node ExperimentReader::List(const YAML::Node& map, const std::string& key,
                                  bool needed) const {
  const YAML::Node list = map[key];
  if (!list && !needed) return list;
  if (!list || !list.IsSequence() || list.size() == 0) {
    Fail(list ? list : map, "`" + key + "` is a list with at least one entry");
  }
  return list;
}

// A name is a folder's, too.
void ExperimentReader::CheckName(const YAML::Node& node, const std::string& name,
                                 std::set<std::string>* taken) const {
  static const char* kLetters =
      "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789_-.+:";
  if (name[0] == '.' || name.find_first_not_of(kLetters) != std::string::npos) {
    Fail(node, "a name is made of letters, digits and _ - . + : and does not begin with .");
  }
  if (!taken->insert(name).second) Fail(node, "the name " + name + " is taken");
}

std::string ExperimentReader::Name(const YAML::Node& map, const std::string& kind,
                                   std::set<std::string>* taken) const {
  const std::string name = Text(map, "name", "");
  if (name.empty()) Fail(map, kind + " needs a `name`");
  CheckName(map["name"], name, taken);
  return name;
}

void ExperimentReader::AddFlag(const YAML::Node& key, const YAML::Node& value,
                               const std::string& command, FlagValues* flags) const {
  const auto name = Value<std::string>(key, "a flag's name");
  const auto text = Value<std::string>(value, "the flag " + name);
  const std::string reason = check_(command, name, text);
  if (!reason.empty()) Fail(value, reason);
  if (!flags->emplace(name, text).second) Fail(key, "the flag " + name + " is given twice");
}

FlagValues ExperimentReader::Flags(const YAML::Node& node, const std::string& command) const {
  FlagValues flags;
  if (!node || node.IsNull()) return flags;
  if (!node.IsMap()) Fail(node, "flags are `name: value` entries, without dashes");
  for (const auto& entry : node) AddFlag(entry.first, entry.second, command, &flags);
  return flags;
}

std::uint64_t ExperimentReader::Seed(const YAML::Node& node, std::string_view text) const {
  std::uint64_t seed = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), seed);
  if (error != std::errc() || end != text.data() + text.size()) {
    Fail(node, "seeds are whole numbers or ranges such as 0..9");
  }
  return seed;
}

void ExperimentReader::AddSeeds(const YAML::Node& node, std::vector<std::uint64_t>* seeds) const {
  const auto text = Value<std::string>(node, "a seed");
  const std::size_t dots = text.find("..");
  const std::uint64_t first = Seed(node, std::string_view(text).substr(0, dots));
  const std::uint64_t last =
      dots == std::string::npos ? first : Seed(node, std::string_view(text).substr(dots + 2));
  if (last < first || last - first >= kMostRuns) Fail(node, "there are no such seeds: " + text);
  for (std::uint64_t k = 0; k <= last - first; ++k) seeds->push_back(first + k);
}

std::vector<std::uint64_t> ExperimentReader::Seeds(const YAML::Node& map,
                                                   std::vector<std::uint64_t> fallback) const {
  const YAML::Node node = map["seeds"];
  if (!node) return fallback;
  std::vector<std::uint64_t> seeds;
  if (node.IsSequence()) {
    for (const auto& entry : node) AddSeeds(entry, &seeds);
  } else {
    AddSeeds(node, &seeds);
  }
  if (seeds.empty()) Fail(node, "`seeds` is a list with at least one entry");
  if (std::set<std::uint64_t>(seeds.begin(), seeds.end()).size() != seeds.size()) {
    Fail(node, "a seed is given twice");
  }
  return seeds;
}

SweepDataSet ExperimentReader::DataSet(const YAML::Node& node,
                                       const std::vector<std::uint64_t>& seeds,
                                       std::set<std::string>* taken) const {
  AllowKeys(node, {"name", "site", "simulate", "map_file", "truth", "seeds"});
  SweepDataSet set;
  set.line = Line(node);
  set.name = Name(node, "a data set", taken);
  set.site = File(node, "site");
  set.truth = File(node, "truth");
  set.seeds = Seeds(node, seeds);
  const bool simulated = static_cast<bool>(node["simulate"]);
  if (simulated != set.site.empty()) {
    Fail(node,
         "a data set needs either `site`, a site file, or `simulate`, flags of the simulation");
  }
  if (!simulated && node["map_file"]) Fail(node["map_file"], "`map_file` goes with `simulate`");
  if (simulated && node["truth"]) Fail(node["truth"], "a simulated site brings its own truth");
  set.simulate = Flags(node["simulate"], "simulate");
  set.map_file = Text(node, "map_file", "site.yaml");
  return set;
}

SweepVariant ExperimentReader::Variant(const YAML::Node& node, std::set<std::string>* taken) const {
  AllowKeys(node, {"name", "flags", "grid"});
  return {Name(node, "a variant", taken), Flags(node["flags"], "map"), Line(node)};
}

// Every combination of the flags' values; a variant is called as its values.
std::vector<SweepVariant> ExperimentReader::Grid(const YAML::Node& node,
                                                 std::set<std::string>* taken) const {
  AllowKeys(node, {"grid", "flags"});
  if (!node["grid"].IsMap() || node["grid"].size() == 0)
    Fail(node["grid"], "`grid` is `flag: [values]` entries");
  std::vector<SweepVariant> grid{{"", Flags(node["flags"], "map"), Line(node)}};
  for (const auto& entry : node["grid"]) {
    const auto flag = Value<std::string>(entry.first, "a flag's name");
    std::vector<SweepVariant> finer;
    for (const SweepVariant& variant : grid) {
      for (const auto& value : List(node["grid"], flag, true)) {
        SweepVariant& next = finer.emplace_back(variant);
        AddFlag(entry.first, value, "map", &next.flags);
        next.name += (next.name.empty() ? "" : "_") + next.flags[flag];
      }
    }
    if (finer.size() > kMostRuns) Fail(entry.first, "these are more than a million variants");
    grid = std::move(finer);
  }
  for (const SweepVariant& variant : grid) CheckName(node["grid"], variant.name, taken);
  return grid;
}

std::vector<SweepVariant> ExperimentReader::Variants(const YAML::Node& root) const {
  std::vector<SweepVariant> variants;
  std::set<std::string> taken;
  for (const auto& node : List(root, "variants", true)) {
    if (node.IsMap() && node["grid"]) {
      for (SweepVariant& variant : Grid(node, &taken)) variants.push_back(std::move(variant));
    } else {
      variants.push_back(Variant(node, &taken));
    }
  }
  return variants;
}

SweepMetric ExperimentReader::OwnMetric(const YAML::Node& node) const {
  AllowKeys(node, {"name", "report", "of", "unit", "ratio"});
  SweepMetric metric;
  std::set<std::string> none;
  metric.name = Name(node, "a metric", &none);
  metric.pointer = Text(node, "report", "");
  metric.unit = Text(node, "unit", "");
  const std::string reason = PointerError(metric.pointer);
  if (!reason.empty()) Fail(node["report"] ? node["report"] : node, "`report`: " + reason);
  const std::string of = Text(node, "of", "mean");
  const auto aggregate = ParseAggregate(of);
  if (!aggregate) Fail(node["of"], "`of` is mean, median, max, min, sum or count, not " + of);
  metric.aggregate = *aggregate;
  if (node["ratio"]) metric.is_ratio = Value<bool>(node["ratio"], "ratio");
  return metric;
}

SweepMetric ExperimentReader::Metric(const YAML::Node& node) const {
  if (node.IsMap()) return OwnMetric(node);
  const auto name = Value<std::string>(node, "a metric");
  const auto metric = BuiltinMetric(name);
  if (!metric) {
    Fail(node, "unknown metric '" + name + "' (known: " + BuiltinMetricNames() +
                   "; others by {name: ..., report: JSON pointer})");
  }
  return *metric;
}

std::vector<SweepMetric> ExperimentReader::Metrics(const YAML::Node& root) const {
  const YAML::Node list = List(root, "metrics", false);
  if (!list) return DefaultMetrics();
  std::vector<SweepMetric> metrics;
  std::set<std::string> names;
  for (const auto& node : list) {
    metrics.push_back(Metric(node));
    if (!names.insert(metrics.back().name).second) Fail(node, "this metric is there already");
  }
  return metrics;
}

std::size_t ExperimentReader::Baseline(const YAML::Node& root,
                                       const std::vector<SweepVariant>& variants) const {
  const std::string name = Text(root, "baseline", variants.front().name);
  for (std::size_t v = 0; v < variants.size(); ++v) {
    if (variants[v].name == name) return v;
  }
  Fail(root["baseline"], "there is no variant " + name);
}

void ExperimentReader::Numbers(const YAML::Node& root, Experiment* experiment) const {
  if (root["threads"]) experiment->threads = Value<int>(root["threads"], "threads");
  if (experiment->threads < 0) Fail(root["threads"], "`threads` of a run are 1 or more, or 0: all");
  if (root["level"]) experiment->level = Value<double>(root["level"], "level");
  if (!(experiment->level > 0.0) || !(experiment->level < 1.0)) {
    Fail(root["level"], "`level` lies between 0 and 1");
  }
  const std::string keep = Text(root, "keep", "everything");
  if (keep != "everything" && keep != "results") {
    Fail(root["keep"], "`keep` is everything or results, not " + keep);
  }
  experiment->keeps_everything = keep == "everything";
}

void ExperimentReader::CheckSize(const YAML::Node& root, const Experiment& experiment) const {
  std::size_t runs = 0;
  for (const auto& set : experiment.data_sets) {
    runs += set.seeds.size() * experiment.variants.size();
  }
  if (runs > kMostRuns) Fail(root, "these are more than a million runs");
}

Experiment ExperimentReader::Read() {
  const YAML::Node root = Load();
  if (!root.IsMap()) throw InputError::AtLine(path_, 1, "is not an experiment's file");
  AllowKeys(root, {"name", "data_sets", "variants", "seeds", "baseline", "metrics", "threads",
                   "level", "keep"});
  Experiment experiment;
  experiment.path = path_;
  experiment.name = Text(root, "name", fs::path(path_).stem().string());
  const std::vector<std::uint64_t> seeds = Seeds(root, {0});
  std::set<std::string> sets{"all"};  // `all`: the rows over all data sets
  for (const auto& node : List(root, "data_sets", true)) {
    experiment.data_sets.push_back(DataSet(node, seeds, &sets));
  }
  experiment.variants = Variants(root);
  experiment.metrics = Metrics(root);
  experiment.has_default_metrics = !root["metrics"];
  experiment.baseline = Baseline(root, experiment.variants);
  Numbers(root, &experiment);
  CheckSize(root, experiment);
  return experiment;
}

}  // namespace

Experiment ReadExperiment(const std::string& path, const std::string& data_folder,
                          const FlagCheck& check) {
  const fs::path folder =
      data_folder.empty() ? fs::path(path).parent_path() : fs::path(data_folder);
  return ExperimentReader(path, folder, check).Read();
}

}  // namespace planegraph
