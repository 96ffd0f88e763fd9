#pragma once

#include <vector>

#include "planegraph/pipeline/pairing.h"

namespace planegraph {

/// Joins scans whose poses mean nothing to each other (robots that started apart and know no map)
/// by the planes that they have in common: scans of two frames are registered without a guess, and
/// where the registrations of different scans give the same motion from one frame to the other, and
/// most of them do (three at least, of two scans or more on either side), the frames become one. A
/// scan that lies wrongly on a place that looks like its own does so on all scans that see the
/// place. Moves *world_from_scan and renumbers *frames of those that were joined; returns
/// the registrations that agree.
std::vector<PairRecord> JoinFrames(const std::vector<ScanModel>& models,
                                   const RegistrationOptions& options, int threads,
                                   std::vector<Rigid3>* world_from_scan, std::vector<int>* frames);

}  // namespace planegraph
