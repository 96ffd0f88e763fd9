#include "solve/group_switch.h"

#include <algorithm>

#include "planegraph/base/chi_square.h"

namespace planegraph {
namespace {

// Of one residual that a graduated loss weighs. `eliminated` has the mean of as many as its weight
// and hides the plane's own unknowns.
int DegreesOf(const Residual& residual) {
  return residual.cost->num_residuals() - (HidesPlane(residual) ? kPlaneTangent : 0);
}

double LimitOf(const Residual& residual, const LossSpec& loss) {
  const double limit = GraduatedThreshold(loss, DegreesOf(residual));
  return loss.scale > 0.0 && HidesPlane(residual) ? residual.weight * limit : limit;
}

}  // namespace

double GroupThreshold(int members, int degrees_of_freedom) {
  const int wrong = (members - 1) / 2;
  const double share = static_cast<double>(members - wrong) / members;
  const double one = ChiSquareQuantile(0.99, degrees_of_freedom / members);
  const int right_degrees = std::max(1, static_cast<int>(share * degrees_of_freedom));
  return ChiSquareQuantile(0.99, right_degrees) / one + wrong;
}

double RelativeOdds(double share, double threshold_share) {
  constexpr double kLargest = 1e6;
  const double rest = 1.0 - share;
  if (rest * kLargest * threshold_share <= share * (1.0 - threshold_share)) return kLargest;
  return share * (1.0 - threshold_share) / (rest * threshold_share);
}

GroupSwitch::GroupSwitch(const SwitchGroup& group, Assembly* assembly)
    : group_(&group), assembly_(assembly) {
  int degrees = 0;
  for (const int index : group.residuals) {
    const Residual& residual = assembly->residuals()[index];
    limits_.push_back(LimitOf(residual, *group.loss));
    degrees += DegreesOf(residual);
  }
  const int members = static_cast<int>(limits_.size());
  threshold_share_ = GroupThreshold(members, degrees) / members;
}

void GroupSwitch::Measure(std::vector<double>* chi2) {
  chi2_.clear();
  for (std::size_t k = 0; k < limits_.size(); ++k) {
    const Residual& residual = assembly_->residuals()[group_->residuals[k]];
    const double share = HidesPlane(residual) ? residual.weight : 1.0;
    chi2_.push_back(share * assembly_->Chi2(residual, nullptr) / limits_[k]);
  }
  group_chi2_ = MeasureGroup();
  chi2->insert(chi2->end(), chi2_.begin(), chi2_.end());
  if (limits_.size() > 1) chi2->push_back(group_chi2_);
}

// Of a single residual 0: it has its own switch. No larger than the members' mean, which is what
// the first surrogate is chosen for.
double GroupSwitch::MeasureGroup() const {
  if (limits_.size() < 2) return 0.0;
  double truncated = 0.0, sum = 0.0, all = 0.0;
  for (std::size_t k = 0; k < limits_.size(); ++k) {
    truncated += limits_[k] * std::min(chi2_[k], 1.0);
    sum += limits_[k] * chi2_[k];
    all += limits_[k];
  }
  const double odds = RelativeOdds(truncated / all, threshold_share_);
  const double mean = std::max(sum, truncated) / (all * threshold_share_);
  return odds > 1.0 ? std::min(odds, mean) : odds;
}

void GroupSwitch::SetWeights(const std::function<double(double)>& weight_of_chi2) const {
  const double of_group = weight_of_chi2(group_chi2_);
  for (std::size_t k = 0; k < limits_.size(); ++k) {
    const double own = assembly_->residuals()[group_->residuals[k]].weight;
    group_->switches[k]->Set(own * of_group * weight_of_chi2(chi2_[k]));
  }
}

}  // namespace planegraph
