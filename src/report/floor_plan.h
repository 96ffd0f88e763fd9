#pragma once

#include <Eigen/Core>
#include <vector>

#include "planegraph/cloud/cloud.h"
#include "report/png.h"

namespace planegraph {

/// The part of the world's xy plane that a picture shows, seen from above. A long y axis is laid
/// across the page: x then points up and y to the left; but where y is north it points up.
struct PlanView {
  bool turned = false;
  bool north_up = false;
  Eigen::Vector2d low = Eigen::Vector2d::Zero();   ///< of the page's axes, metres
  Eigen::Vector2d high = Eigen::Vector2d::Zero();  ///< likewise; above `low` in both

  /// Metres to the right and up on the page, from x and y of the world.
  Eigen::Vector2d OnPage(const Eigen::Vector2d& xy) const {
    return turned ? Eigen::Vector2d(-xy.y(), xy.x()) : xy;
  }
  Eigen::Vector2d Extent() const { return high - low; }
};

/// A view that shows the scans' positions and the map but for its thinnest outskirts (returns
/// through windows, reflections). `is_east_north`: so the world's x and y point.
PlanView ChooseView(const Cloud& map, const std::vector<Eigen::Vector3d>& positions,
                    bool is_east_north = false);

/// The map from above as a plan. Dark: what stands upright between 0.3 and 1.8 m above the ground
/// around it (walls, furniture), the darker the more of that height it fills, so that floors,
/// ceilings and table tops stay light; coloured: what rises above that (facades, trees, shelves);
/// faint: everything else that was seen. The ground is found from the points, cell by cell.
struct FloorPlan {
  IndexedImage image;
  std::vector<Rgba> palette;
};
FloorPlan DrawFloorPlan(const Cloud& map, const PlanView& view);

/// The edge of a pixel of that plan, metres. The picture begins at the lower left of the view.
double PlanPixel(const PlanView& view);

}  // namespace planegraph
