#include "pipeline/group_judgement.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

namespace planegraph {
namespace {

// Of an observation, or of a pair of them; -1: none.
int GroupOf(const Graph& graph, const ResidualTag& tag) {
  if (tag.plane < 0 || tag.observation < 0) return -1;
  const auto& observations = graph.planes[tag.plane].observations;
  const int group = observations[tag.observation].group;
  return group < 0 && tag.other_observation >= 0 ? observations[tag.other_observation].group
                                                 : group;
}

std::string IdOf(const JointProblem& problem, const std::vector<int>& poses, std::size_t k) {
  return k < poses.size() ? (*problem.scans)[poses[k]].id : "";
}

SwitchedOff MeasurementOff(const std::string& type, const std::string& measured_by,
                           const ResidualReport& report) {
  SwitchedOff off;
  off.kind = type;
  off.by = "loss";
  off.weight = report.weight;
  off.sigmas = std::sqrt(report.chi2);
  char text[160];
  std::snprintf(
      text, sizeof(text),
      "measured by %s: it is %.1f standard deviations off, which leaves it a weight of %.3f",
      measured_by.c_str(), off.sigmas, off.weight);
  off.reason = text;
  return off;
}

}  // namespace

void GroupJudgement::Record(const Graph& graph, const SolveSummary& summary, const LossSpec& loss) {
  std::map<int, State> seen;
  for (const ResidualReport& report : summary.residuals) {
    const int group = GroupOf(graph, report.tag);
    if (group < 0) continue;
    State& state = seen[group];
    state.limit = GraduatedThreshold(loss, report.dimension);
    state.chi2 += report.chi2;
    state.weight = std::max(state.weight, report.weight);
    state.wrong += report.chi2 > state.limit ? 1 : 0;
    ++state.planes;
  }
  for (const auto& [group, state] : seen) states_[group] = state;
}

SwitchedOff GroupJudgement::Describe(const State& state) const {
  SwitchedOff off;
  off.by = "loss";
  off.weight = state.weight;
  off.sigmas = std::sqrt(state.chi2 / state.planes);
  off.threshold_sigmas = std::sqrt(state.limit);
  char text[200];
  std::snprintf(
      text, sizeof(text),
      "%d of the %d planes that it brought are more than %.1f standard deviations off (rms "
      "%.1f): fewer than half may be",
      state.wrong, state.planes, off.threshold_sigmas, off.sigmas);
  off.reason = text;
  return off;
}

std::vector<SwitchedOff> GroupJudgement::Off() const {
  std::vector<SwitchedOff> list;
  const auto add = [&](int group, const std::string& kind, const std::string& target,
                       std::size_t scan) {
    const auto state = states_.find(group);
    if (group < 0 || state == states_.end() || state->second.weight >= kOffWeight) return;
    list.push_back(Describe(state->second));
    list.back().kind = kind;
    list.back().target = target;
    list.back().source = (*problem_.scans)[scan].id;
  };
  for (std::size_t k = 0; k < problem_.pairs->size(); ++k) {
    const PairRecord& pair = (*problem_.pairs)[k];
    add(groups_.OfPair(k), "laser-laser", (*problem_.scans)[pair.target].id, pair.source);
  }
  for (std::size_t k = 0; k < problem_.map_pairs->size(); ++k) {
    const MapPairRecord& pair = (*problem_.map_pairs)[k];
    add(groups_.OfMapPair(k), "laser-map", (*problem_.maps)[pair.map].id, pair.scan);
  }
  return list;
}

void RemoveSwitchedOff(const SolveSummary& summary, Graph* graph) {
  std::vector<std::vector<bool>> off;
  for (const PlaneLandmark& plane : graph->planes) {
    off.emplace_back(plane.observations.size(), false);
  }
  for (const ResidualReport& report : summary.residuals) {
    const ResidualTag& tag = report.tag;
    if (tag.plane < 0 || tag.observation < 0 || tag.other_observation >= 0) continue;
    off[tag.plane][tag.observation] = report.weight < kOffWeight;
  }
  for (std::size_t p = 0; p < off.size(); ++p) {
    auto& observations = graph->planes[p].observations;
    std::size_t kept = 0;
    for (std::size_t k = 0; k < observations.size(); ++k) {
      if (!off[p][k]) observations[kept++] = observations[k];
    }
    observations.resize(kept);
  }
  std::erase_if(graph->planes, [](const auto& plane) { return plane.observations.size() < 2; });
}

std::vector<SwitchedOff> MeasurementsOff(const JointProblem& problem, const Graph& graph,
                                         const SolveSummary& summary) {
  std::vector<SwitchedOff> list;
  for (const ResidualReport& report : summary.residuals) {
    if (report.weight >= kOffWeight) continue;
    if (report.tag.pose_factor >= 0) {
      const PoseFactor& factor = graph.pose_factors[report.tag.pose_factor];
      list.push_back(MeasurementOff(factor.type, factor.source, report));
      list.back().target = IdOf(problem, factor.poses, 0);
      list.back().source = IdOf(problem, factor.poses, 1);
    } else if (report.tag.map_factor >= 0) {
      const MapFactor& factor = graph.map_factors[report.tag.map_factor];
      list.push_back(MeasurementOff(factor.type, factor.source, report));
      list.back().target = graph.maps[factor.maps[0]].id;
    }
  }
  return list;
}

}  // namespace planegraph
