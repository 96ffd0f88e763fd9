#pragma once

#include <vector>

#include "planegraph/graph/consistency.h"
#include "planegraph/pipeline/chain.h"
#include "planegraph/pipeline/switched_off.h"

namespace planegraph {

/// Whether a registration joins two scans of one robot that follow each other.
bool IsStep(const std::vector<ScanRecord>& scans, const PairRecord& pair);

/// What is trusted before loops are looked at: odometry, and the used registrations of scans that
/// follow each other.
std::vector<RelativePose> TrustedSteps(const std::vector<ScanRecord>& scans,
                                       const std::vector<PairRecord>& pairs,
                                       const std::vector<OdometryStep>& odometry);

/// Used registrations of scans that do not follow each other, as closures, and their places in
/// `pairs`.
struct Loops {
  std::vector<RelativePose> closures;
  std::vector<std::size_t> pairs;
};
Loops UsedLoops(const std::vector<ScanRecord>& scans, const std::vector<PairRecord>& pairs);

/// Takes the used registrations out that are not in the largest consistent set (FindConsistentSet,
/// variances as the registrations themselves show them): each becomes `ambiguous`, with the reason.
void RefuseInconsistentLoops(const std::vector<ScanRecord>& scans,
                             const std::vector<OdometryStep>& odometry,
                             std::vector<PairRecord>* pairs, std::vector<SwitchedOff>* off);

}  // namespace planegraph
