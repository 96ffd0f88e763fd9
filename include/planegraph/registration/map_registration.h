#pragma once

#include <functional>
#include <string>
#include <vector>

#include "planegraph/registration/map_evidence.h"
#include "planegraph/registration/map_refinement.h"
#include "planegraph/registration/registration.h"

namespace planegraph {

/// A pose in the map that the search came upon.
struct MapCandidate {
  MapRefinement refinement;
  MapEvidence evidence;
  double log_likelihood = 0.0;  ///< over that of a pose without any relation to the truth, nats
  double log_prior = 0.0;       ///< by the start, over that of the window searched, nats
  /// That this is where the scans stand, among all candidates and the chance that it is none of
  /// them.
  double probability = 0.0;
};

struct MapLocationOptions {
  MapPrior prior;
  std::size_t most_hypotheses = 400;  ///< after the vote
  std::size_t most_refined = 40;      ///< after a first look by few samples
  double gate = 0.1;                  ///< metres, of the evidence; five sigmas of the map at least
  double most_chance = 1e-3;          ///< largest probability of an error that is still `ok`
  int threads = 1;
  /// Is told the share of the search that is done, from any thread.
  std::function<void(double)> progress = [](double) {};
};

/// The pose some decimetres beside the best one that rivals it most.
struct MapSlide {
  Eigen::Vector3d direction = Eigen::Vector3d::Zero();  ///< unit, map's axes: from the best pose
  double metres = 0.0;                                  ///< how far it is from that
  double probability = 0.0;                             ///< that the scans stand there
};

/// Where a group of scans stands in a map.
struct MapLocation {
  RegistrationStatus status = RegistrationStatus::kFailed;
  std::string reason;
  std::vector<MapCandidate> candidates;  ///< different poses, best first
  double r1 = 0.0, r2 = 0.0;             ///< probabilities of the two best
  double chance = 1.0;                   ///< probability that the best one is wrong
  double background = 0.5;               ///< what of the map's word wrong poses get confirmed
  double nowhere = 1.0;                  ///< and of it, that the scans stand at none of them
  MapSlide slid;                         ///< and of it, that they stand beside it
};

/// Planes of the map and of a scan that lie on each other, by the scan's samples, most first.
std::vector<PlanePair> MapCorrespondences(const MapModel& map, const ScanModel& scan,
                                          const Sim3& map_from_scan, double gate);

/// Finds the group in the map: votes, a first look, refinement, evidence; compares different poses
/// only. `failed` where chance could have made the best one, `ambiguous` where another one rivals
/// it.
MapLocation LocateInMap(const MapModel& map, const ScanGroup& group,
                        const MapLocationOptions& options);

}  // namespace planegraph
