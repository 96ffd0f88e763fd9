#include "planegraph/pipeline/loop_consistency.h"

#include <cmath>
#include <cstdio>

#include "planegraph/base/counted.h"

namespace planegraph {
namespace {

std::string NameOf(const std::vector<ScanRecord>& scans, const PairRecord& pair) {
  return scans[pair.target].id + "-" + scans[pair.source].id;
}

// "it contradicts the way between its scans and 4 other registrations: 57 standard deviations"
std::string InWords(const SwitchedOff& off, bool with_way) {
  char text[200];
  const std::string others =
      off.contradicts.empty() ? "" : Counted(off.contradicts.size(), "other registration");
  const std::string what = with_way ? "the way between its scans" : "";
  const std::string both = what + (what.empty() || others.empty() ? "" : " and ") + others;
  std::snprintf(text, sizeof(text), "it contradicts %s: %.0f standard deviations of at most %.1f",
                both.empty() ? "the other registrations" : both.c_str(), off.sigmas,
                off.threshold_sigmas);
  return text;
}

}  // namespace

bool IsStep(const std::vector<ScanRecord>& scans, const PairRecord& pair) {
  return pair.source == pair.target + 1 && scans[pair.target].robot == scans[pair.source].robot;
}

std::vector<RelativePose> TrustedSteps(const std::vector<ScanRecord>& scans,
                                       const std::vector<PairRecord>& pairs,
                                       const std::vector<OdometryStep>& odometry) {
  std::vector<RelativePose> steps;
  for (const PairRecord& pair : pairs) {
    if (!pair.used || !IsStep(scans, pair)) continue;
    steps.push_back({static_cast<int>(pair.target), static_cast<int>(pair.source),
                     pair.registration.target_from_source(),
                     pair.registration.refinement.covariance});
  }
  for (const OdometryStep& step : odometry) {
    steps.push_back({static_cast<int>(step.target), static_cast<int>(step.source),
                     step.target_from_source, step.covariance});
  }
  return steps;
}

Loops UsedLoops(const std::vector<ScanRecord>& scans, const std::vector<PairRecord>& pairs) {
  Loops loops;
  for (std::size_t k = 0; k < pairs.size(); ++k) {
    if (!pairs[k].used || IsStep(scans, pairs[k])) continue;
    loops.closures.push_back({static_cast<int>(pairs[k].target), static_cast<int>(pairs[k].source),
                              pairs[k].registration.target_from_source(),
                              pairs[k].registration.refinement.covariance});
    loops.pairs.push_back(k);
  }
  return loops;
}

void RefuseInconsistentLoops(const std::vector<ScanRecord>& scans,
                             const std::vector<OdometryStep>& odometry,
                             std::vector<PairRecord>* pairs, std::vector<SwitchedOff>* off) {
  const int count = static_cast<int>(scans.size());
  const Loops loops = UsedLoops(scans, *pairs);
  const std::vector<RelativePose> trusted = TrustedSteps(scans, *pairs, odometry);
  ConsistencyOptions options;
  options.variance_factor = MeasureVarianceFactor(count, trusted, loops.closures);
  const ConsistentSet set = FindConsistentSet(count, trusted, loops.closures, options);
  for (const Inconsistency& found : set.refused) {
    PairRecord& pair = (*pairs)[loops.pairs[found.measurement]];
    SwitchedOff entry{"laser-laser", scans[pair.target].id, scans[pair.source].id, "consistency"};
    entry.sigmas = std::sqrt(found.chi2);
    entry.threshold_sigmas = std::sqrt(found.limit);
    for (const std::size_t k : found.against) {
      entry.contradicts.push_back(NameOf(scans, (*pairs)[loops.pairs[k]]));
    }
    entry.reason = InWords(entry, found.with_way);
    pair.registration.status = RegistrationStatus::kAmbiguous;
    pair.registration.reason = entry.reason;
    pair.used = false;
    off->push_back(std::move(entry));
  }
}

}  // namespace planegraph
