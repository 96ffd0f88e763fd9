#pragma once

#include "planegraph/registration/map_evidence.h"
#include "planegraph/registration/map_refinement.h"

namespace planegraph {

/// A pose beside the one that was found.
struct Slide {
  Sim3 map_from_group;
  double metres = 0.0;  ///< from the pose that was found
  /// Log of the odds of the pose that was found over this one, nats.
  double lead = 0.0;
};

/// The pose that fits best of those two to four of the refinement's last gates off along the
/// principal axes of the pose's uncertainty. What both poses confirm does not tell them apart; of
/// what only one of them confirms or contradicts, nine surfaces in ten speak for the right one (as
/// everywhere in the evidence), so that each is worth log 9. A pose is no better than the few
/// surfaces that face the direction in which it is weakest: a wall's other side or a gable's makes
/// one that is off by its thickness.
Slide ClosestSlide(const MapModel& map, const ScanGroup& group, const MapRefinement& found,
                   double gate);

}  // namespace planegraph
