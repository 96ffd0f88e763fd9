#pragma once

#include "report/floor_plan.h"

namespace planegraph {

/// What a drone saw from above in its own colours, muted: of each pixel the mean of its topmost
/// points, small holes filled. The picture begins at the lower left of the view. Empty where the
/// cloud has no colours or no points in the view.
struct DronePhoto {
  IndexedImage image;
  std::vector<Rgba> palette;
  double pixel = 0.0;  ///< metres
};
DronePhoto DrawDronePhoto(const Cloud& drone, const PlanView& view);

}  // namespace planegraph
