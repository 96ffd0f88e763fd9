#pragma once

#include <vector>

#include "planegraph/correspondence/map_model.h"
#include "planegraph/correspondence/scan_group.h"
#include "planegraph/geometry/sim3.h"

namespace planegraph {

/// What speaks for a place in the map and what against it.
struct MapEvidence {
  /// Share of the scans' surfaces (all directions alike) that lie on a surface of the map which
  /// faces the same way; mean over the better half of the scans: a group may go on where the map
  /// does not.
  double agree = 0.0;
  /// The same in the direction of translation in which it is worst.
  double worst_direction = 0.0;
  std::vector<double> agree_by_scan;  ///< of every scan

  /// Shares of all scans' surfaces: on the map; and not, though the map knows that nothing is
  /// there. About the rest the map is silent.
  double confirmed = 0.0, contradicted = 0.0;
  double surfaces = 0.0;  ///< independent ones among them: what lies close together errs together
  double expected_contradicted = 0.1;  ///< at a right pose, of what the map speaks about
  /// Of the map's surfaces about the scans whose place the laser has seen, the share that it looked
  /// through, and how many independent ones it has seen.
  double pierced = 0.0, viewed = 0.0;

  /// Of what the map speaks about, the share that it confirms; 0.5 where it is silent.
  double ConfirmedShare() const;
};

/// The evidence for a pose. `gate`: metres along the normal.
MapEvidence MeasureEvidence(const MapModel& map, const ScanGroup& group, const Sim3& map_from_group,
                            double gate);

/// What a wrong pose looks like: the share of what the map speaks about that it confirms there.
double BackgroundShare(const std::vector<const MapEvidence*>& wrong);

/// Log of the likelihood of the evidence if the pose is right, over that if it is unrelated to the
/// truth, nats. Each independent surface is one trial: confirmed or contradicted. At a right pose
/// one in ten is contradicted (things that moved, errors of the map), at a wrong one the share
/// 1 - `background`. A laser that looks through more of the map than it may is counted against the
/// pose by Chernoff's bound.
double LogLikelihoodRatio(const MapEvidence& evidence, double background);

}  // namespace planegraph
