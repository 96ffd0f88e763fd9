#pragma once

#include <cmath>
#include <optional>
#include <string>
#include <vector>

#include "locate/located_site.h"
#include "planegraph/registration/map_registration.h"

namespace planegraph {

/// What became of one try to find a scan, or a group of them, in the map.
struct Outcome {
  std::size_t scan = 0;  ///< the first one of the group
  std::size_t scans = 1;
  bool covered = false;
  RegistrationStatus status = RegistrationStatus::kFailed;
  std::string reason;
  double metres = 0.0, degrees = 0.0;          ///< of the best candidate, in true metres
  bool near = false;                           ///< within 1 m and 5 degrees
  double chance = 1.0, nowhere = 1.0;          ///< probabilities: see MapLocation
  double confirmed = 0.0, contradicted = 0.0;  ///< at the best pose
  // Log-likelihood ratios (nats): of the best candidate, of the pose refined from the truth, and of
  // the best candidate that is not near the truth (-infinity: none).
  double best = 0.0, truth = 0.0, wrong_pose = -INFINITY;
  double seconds = 0.0;  ///< of CPU time, one thread

  bool right() const { return status == RegistrationStatus::kOk && near; }
  bool wrong() const { return status == RegistrationStatus::kOk && !near; }
};

/// Looks for each scan by itself: LocateInMap without a pose prior.
std::vector<Outcome> LocateAlone(const LocatedSite& site, int threads);

/// For each scan and the next one of its robot, tied by a registration from the odometry, or by the
/// odometry where that fails, as `planegraph locate` does. Covered: by the mean of the two.
std::vector<Outcome> LocateInPairs(const LocatedSite& site, int threads);

/// The paper's search over cells, for each scan by itself. Scores are the paper's r.
std::vector<Outcome> LocateInCells(const LocatedSite& site, int threads);

}  // namespace planegraph
