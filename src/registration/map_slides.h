#pragma once

#include "planegraph/registration/map_evidence.h"
#include "planegraph/registration/map_refinement.h"

namespace planegraph {

/// A pose beside the one that was found.
struct Slide {
  Sim3 map_from_group;
  Eigen::Vector3d direction = Eigen::Vector3d::Zero();  ///< unit, map's axes
  double metres = 0.0;                                  ///< from the pose that was found
  /// Log of the odds of the pose that was found over this one, nats: by all surfaces, and where one
  /// of the walls may be another one.
  double lead_of_all = 0.0, lead = 0.0;
};

/// The pose that fits best of those two to four of the refinement's last gates off along the
/// principal axes of the pose's uncertainty (see PoseRivals).
Slide ClosestSlide(const MapModel& map, const ScanGroup& group, const MapRefinement& found,
                   double gate);

}  // namespace planegraph
