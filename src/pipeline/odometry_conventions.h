#pragma once

#include <string>
#include <vector>

#include "planegraph/pipeline/pairing.h"

namespace planegraph {

/// Robots whose odometry does not mean what its format says: in another unit, with other axes, with
/// w first, or body from world. `chain` holds the registrations of consecutive scans, found without
/// a guess where the odometry led nowhere. A robot is warned of where
/// 1. most of its steps agree with what was registered once the odometry is taken in one such way,
///    within the noise of a usual odometry, and beyond all chance do not as it stands (three at
///    least that went somewhere: a scanner at rest looks alike in all units and axes), or
/// 2. most of its steps are longer than its scans reach, so that no two scans could have anything
///    in common.
/// The result is not changed.
std::vector<std::string> OdometryConventionWarnings(const Site& site,
                                                    const std::vector<ScanRecord>& scans,
                                                    const std::vector<PairRecord>& chain);

}  // namespace planegraph
