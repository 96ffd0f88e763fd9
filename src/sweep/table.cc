#include "planegraph/sweep/table.h"

#include <algorithm>
#include <cmath>
#include <map>

#include "planegraph/evaluation/median_interval.h"
#include "planegraph/evaluation/paired_test.h"
#include "planegraph/evaluation/statistics.h"

namespace planegraph {
namespace {

// A metric of one run beside that of the baseline on the same site with the same seed.
struct Observation {
  std::optional<double> value, baseline;
};

bool operator==(const Observation& a, const Observation& b) {
  return a.value == b.value && a.baseline == b.baseline;
}

std::optional<double> ValueOf(const SweepRun& run, std::size_t metric) {
  return run.succeeded() ? run.values[metric] : std::nullopt;
}

class TableMaker {
 public:
  TableMaker(const Experiment& experiment, const std::vector<SweepRun>& runs)
      : experiment_(experiment), runs_(runs) {
    for (const SweepRun& run : runs) by_place_[{run.data_set, run.variant, run.seed}] = &run;
  }

  std::vector<SweepRow> Make() const;

 private:
  using Place = std::tuple<std::size_t, std::size_t, std::uint64_t>;

  std::vector<Observation> Observe(std::size_t set, std::size_t variant, std::size_t metric) const;
  SweepCell Cell(const std::vector<Observation>& observations, std::size_t metric,
                 bool is_baseline) const;
  void Compare(const std::vector<Observation>& observations, bool is_ratio, SweepCell* cell) const;
  SweepRow Row(const std::vector<std::size_t>& sets, const std::string& name,
               std::size_t variant) const;
  void Adjust(std::vector<SweepRow>* rows) const;

  const Experiment& experiment_;
  const std::vector<SweepRun>& runs_;
  std::map<Place, const SweepRun*> by_place_;
};

std::vector<Observation> TableMaker::Observe(std::size_t set, std::size_t variant,
                                             std::size_t metric) const {
  std::vector<Observation> observations;
  for (std::uint64_t seed : experiment_.data_sets[set].seeds) {
    const SweepRun& run = *by_place_.at({set, variant, seed});
    const SweepRun& baseline = *by_place_.at({set, experiment_.baseline, seed});
    observations.push_back({ValueOf(run, metric), ValueOf(baseline, metric)});
  }
  // The same files gave the same result again and again: that is one result.
  const bool repeats = !experiment_.data_sets[set].is_simulated() &&
                       std::all_of(observations.begin(), observations.end(),
                                   [&](const auto& o) { return o == observations.front(); });
  if (repeats) observations.resize(1);
  return observations;
}

void TableMaker::Compare(const std::vector<Observation>& observations, bool is_ratio,
                         SweepCell* cell) const {
  std::vector<double> changes, differences;
  for (const Observation& o : observations) {
    if (!o.value || !o.baseline) continue;
    if (is_ratio && !(*o.value > 0.0 && *o.baseline > 0.0)) continue;
    changes.push_back(is_ratio ? *o.value / *o.baseline : *o.value - *o.baseline);
    differences.push_back(is_ratio ? std::log(changes.back()) : changes.back());
  }
  cell->pairs = changes.size();
  if (changes.empty()) return;
  cell->change = Summarize(changes).median;
  cell->change_interval = BootstrapMedianInterval(changes, experiment_.level);
  if (changes.size() < LeastForMedianInterval(experiment_.level)) return;
  cell->p = WilcoxonSignedRank(differences).p;
}

SweepCell TableMaker::Cell(const std::vector<Observation>& observations, std::size_t metric,
                           bool is_baseline) const {
  SweepCell cell;
  std::vector<double> values;
  for (const Observation& o : observations) {
    if (o.value) values.push_back(*o.value);
  }
  cell.count = values.size();
  if (!values.empty()) {
    const Statistics statistics = Summarize(values);
    cell.median = statistics.median;
    cell.mean = statistics.mean;
    cell.min = statistics.min;
    cell.max = statistics.max;
    cell.interval = BootstrapMedianInterval(values, experiment_.level);
  }
  if (!is_baseline) Compare(observations, experiment_.metrics[metric].is_ratio, &cell);
  return cell;
}

SweepRow TableMaker::Row(const std::vector<std::size_t>& sets, const std::string& name,
                         std::size_t variant) const {
  SweepRow row;
  row.data_set = name;
  row.variant = experiment_.variants[variant].name;
  row.is_baseline = variant == experiment_.baseline;
  for (const SweepRun& run : runs_) {
    if (run.variant != variant || !std::count(sets.begin(), sets.end(), run.data_set)) continue;
    ++row.runs;
    row.succeeded += run.succeeded() ? 1 : 0;
  }
  for (std::size_t m = 0; m < experiment_.metrics.size(); ++m) {
    std::vector<Observation> observations;
    for (std::size_t set : sets) {
      const auto more = Observe(set, variant, m);
      observations.insert(observations.end(), more.begin(), more.end());
    }
    row.cells.push_back(Cell(observations, m, row.is_baseline));
  }
  return row;
}

// All tests of a metric in these rows are one family.
void TableMaker::Adjust(std::vector<SweepRow>* rows) const {
  for (std::size_t m = 0; m < experiment_.metrics.size(); ++m) {
    std::vector<double> p_values;
    for (const SweepRow& row : *rows) {
      if (row.cells[m].p) p_values.push_back(*row.cells[m].p);
    }
    const std::vector<double> adjusted = HolmAdjusted(p_values);
    std::size_t next = 0;
    for (SweepRow& row : *rows) {
      if (row.cells[m].p) row.cells[m].p_holm = adjusted[next++];
    }
  }
}

std::vector<SweepRow> TableMaker::Make() const {
  std::vector<SweepRow> rows, whole;
  std::vector<std::size_t> sets;
  for (std::size_t d = 0; d < experiment_.data_sets.size(); ++d) {
    sets.push_back(d);
    for (std::size_t v = 0; v < experiment_.variants.size(); ++v) {
      rows.push_back(Row({d}, experiment_.data_sets[d].name, v));
    }
  }
  Adjust(&rows);
  if (sets.size() < 2) return rows;
  for (std::size_t v = 0; v < experiment_.variants.size(); ++v) {
    whole.push_back(Row(sets, "all", v));
  }
  Adjust(&whole);
  rows.insert(rows.end(), whole.begin(), whole.end());
  return rows;
}

}  // namespace

std::vector<std::string> EmptyMetrics(const Experiment& experiment,
                                      const std::vector<SweepRun>& runs) {
  std::vector<std::string> empty;
  for (std::size_t m = 0; m < experiment.metrics.size(); ++m) {
    const bool has_value = std::any_of(
        runs.begin(), runs.end(), [m](const SweepRun& run) { return run.values[m].has_value(); });
    if (!has_value) empty.push_back(experiment.metrics[m].name);
  }
  return empty;
}

void LeaveOut(const std::string& metric, Experiment* experiment, std::vector<SweepRun>* runs) {
  auto& metrics = experiment->metrics;
  const auto found = std::find_if(metrics.begin(), metrics.end(),
                                  [&](const SweepMetric& m) { return m.name == metric; });
  if (found == metrics.end()) return;
  for (SweepRun& run : *runs) run.values.erase(run.values.begin() + (found - metrics.begin()));
  metrics.erase(found);
}

std::vector<SweepRow> MakeSweepTable(const Experiment& experiment,
                                     const std::vector<SweepRun>& runs) {
  return TableMaker(experiment, runs).Make();
}

}  // namespace planegraph
