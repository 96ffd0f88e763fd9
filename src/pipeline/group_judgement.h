#pragma once

#include <map>
#include <vector>

#include "pipeline/registration_groups.h"

namespace planegraph {

/// What a graduated loss has switched off, round by round: of each group the last that was seen of
/// it.
class GroupJudgement {
 public:
  explicit GroupJudgement(const JointProblem& problem) : problem_(problem), groups_(problem) {}

  void Apply(Graph* graph) const { groups_.Apply(graph); }
  /// After a solve of a graph with these groups, with its residuals.
  void Record(const Graph& graph, const SolveSummary& summary, const LossSpec& loss);
  /// The registrations of the groups that are off, in their order.
  std::vector<SwitchedOff> Off() const;

 private:
  struct State {
    int planes = 0, wrong = 0;
    double chi2 = 0.0, weight = 0.0, limit = 0.0;  // the limit: of one observation
  };
  SwitchedOff Describe(const State& state) const;

  const JointProblem& problem_;
  RegistrationGroups groups_;
  std::map<int, State> states_;
};

/// Takes observations out that are off, and landmarks that are left with fewer than two.
void RemoveSwitchedOff(const SolveSummary& summary, Graph* graph);

/// Single measurements of poses and maps (odometry, GPS, starts) that a loss has switched off.
std::vector<SwitchedOff> MeasurementsOff(const JointProblem& problem, const Graph& graph,
                                         const SolveSummary& summary);

}  // namespace planegraph
