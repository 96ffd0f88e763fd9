#pragma once

#include <functional>
#include <vector>

#include "solve/assembly.h"

namespace planegraph {

/// Largest sum of truncated chi2 of a group that is right, in units of a member's limit c^2: fewer
/// than half of its `members` may be wrong, each for its limit, and the others have what chance
/// gives all of their degrees of freedom together (99 %). For one member: 1, its own limit.
double GroupThreshold(int members, int degrees_of_freedom);

/// A group's chi2 relative to its threshold, 1 there and without bound for a group all of which is
/// wrong: the odds of its truncated sum (`share` of the largest possible) over the threshold's.
double RelativeOdds(double share, double threshold_share);

/// One switch of a graduated loss: of a single residual, or of a group on top of its members' own
/// ones. A member's weight is its own times the group's, so that one wrong plane neither condemns
/// its registration nor pulls at it.
class GroupSwitch {
 public:
  GroupSwitch(const SwitchGroup& group, Assembly* assembly);

  /// At the assembly's present values; appends what the schedule has to know to *chi2, relative to
  /// the limits.
  void Measure(std::vector<double>* chi2);
  void SetWeights(const std::function<double(double)>& weight_of_chi2) const;

 private:
  double MeasureGroup() const;

  const SwitchGroup* group_;
  Assembly* assembly_;
  std::vector<double> limits_;    // c^2 of each member
  double threshold_share_ = 1.0;  // of the sum of the limits
  std::vector<double> chi2_;      // of each member, relative to its limit
  double group_chi2_ = 0.0;
};

}  // namespace planegraph
