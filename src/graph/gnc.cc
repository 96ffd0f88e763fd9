#include "planegraph/graph/gnc.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace planegraph {
namespace {

constexpr double kHardest = 1e6;  // the truncated surrogate then differs from its limit by c^2 1e-6

}  // namespace

GncSchedule::GncSchedule(GncKernel kernel, double scale, double factor)
    : kernel_(kernel), c2_(scale * scale), factor_(factor) {
  if (!(scale > 0.0 && factor > 1.0)) throw std::invalid_argument("GNC: scale or factor");
}

void GncSchedule::Start(const std::vector<double>& chi2) {
  double largest = 0.0;
  for (const double s : chi2) largest = std::max(largest, s);
  finished_ = largest <= c2_;
  if (kernel_ == GncKernel::kTruncated) {
    mu_ = finished_ ? kHardest : c2_ / (2.0 * largest - c2_);
  } else {
    mu_ = std::max(1.0, 2.0 * largest / c2_);
  }
}

double GncSchedule::Weight(double chi2) const {
  if (kernel_ == GncKernel::kGemanMcClure) {
    const double root = mu_ * c2_ / (mu_ * c2_ + chi2);
    return root * root;
  }
  if (chi2 <= mu_ / (mu_ + 1.0) * c2_) return 1.0;
  if (chi2 >= (mu_ + 1.0) / mu_ * c2_) return 0.0;
  return std::clamp(std::sqrt(c2_ * mu_ * (mu_ + 1.0) / chi2) - mu_, 0.0, 1.0);
}

bool GncSchedule::AllBinary(const std::vector<double>& chi2) const {
  return std::all_of(chi2.begin(), chi2.end(), [&](double s) {
    const double weight = Weight(s);
    return weight == 0.0 || weight == 1.0;
  });
}

void GncSchedule::Advance(const std::vector<double>& chi2) {
  if (kernel_ == GncKernel::kGemanMcClure) {
    finished_ = mu_ <= 1.0;
    mu_ = std::max(1.0, mu_ / factor_);
    return;
  }
  mu_ *= factor_;
  finished_ = mu_ >= kHardest || AllBinary(chi2);
}

double GncSchedule::FinalWeight(double chi2) const {
  if (kernel_ == GncKernel::kTruncated) return chi2 <= c2_ ? 1.0 : 0.0;
  const double root = c2_ / (c2_ + chi2);
  return root * root;
}

}  // namespace planegraph
