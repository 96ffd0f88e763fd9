#pragma once

#include <string>
#include <vector>

#include "planegraph/registration/map_refinement.h"
#include "planegraph/registration/registration.h"

namespace planegraph {

/// What speaks for a place in the map and what against it.
struct MapEvidence {
  /// Share of the scans' surfaces (all directions alike) that lie on a surface of the map which
  /// faces the same way; mean over the better half of the scans: a group may go on where the map
  /// does not.
  double agree = 0.0;
  /// The same in the direction of translation in which it is worst.
  double worst_direction = 0.0;
  /// Of the map's surfaces about the scans whose place the laser has seen, the share that it looked
  /// through.
  double pierced = 0.0;
  std::vector<double> agree_by_scan;  ///< of every scan

  /// In [0, 1]. A wrong pose easily has the ground right, so that the worst direction counts as
  /// much as the mean.
  double Score() const { return agree * worst_direction * (1.0 - pierced) * (1.0 - pierced); }
};

struct MapCandidate {
  MapRefinement refinement;
  MapEvidence evidence;
};

struct MapLocationOptions {
  MapPrior prior;
  std::size_t most_hypotheses = 400;  ///< after the vote
  std::size_t most_refined = 40;      ///< after a first look by few samples
  double gate = 0.1;                  ///< metres, of the evidence; five sigmas of the map at least
  /// Least score of a pose to be believed: say, a fifth of the surfaces confirmed, and a fifth of
  /// those that face in the worst direction.
  double least_score = 0.04;
  /// Largest probability that the best of all wrong poses reaches the best score (NFA), by the tail
  /// of the scores of the other poses that were found.
  double most_chance = 1e-2;
  double ambiguity = 0.5;  ///< and a different pose with this share of the best score is one
  int threads = 1;
};

/// Where a group of scans stands in a map.
struct MapLocation {
  RegistrationStatus status = RegistrationStatus::kFailed;
  std::string reason;
  std::vector<MapCandidate> candidates;  ///< different poses, best first
  double r1 = 0.0, r2 = 0.0;             ///< scores of the two best
  double chance = 1.0;  ///< probability that a wrong pose looks as good as the best one
};

/// The evidence for a pose. `gate`: metres along the normal.
MapEvidence MeasureEvidence(const MapModel& map, const ScanGroup& group, const Sim3& map_from_group,
                            double gate);

/// Planes of the map and of a scan that lie on each other, by the scan's samples, most first.
std::vector<PlanePair> MapCorrespondences(const MapModel& map, const ScanModel& scan,
                                          const Sim3& map_from_scan, double gate);

/// Finds the group in the map: votes, a first look, refinement, evidence; compares different poses
/// only, and says `ambiguous` rather than guess.
MapLocation LocateInMap(const MapModel& map, const ScanGroup& group,
                        const MapLocationOptions& options);

}  // namespace planegraph
