#include "registration/map_slides.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

#include "registration/pose_rivals.h"

namespace planegraph {
namespace {

// The refinement pairs what is within its last gate, so that poses less than two of these apart see
// the same surfaces and end at the same place; walls and roofs are no thicker than four.
constexpr double kGates[] = {2.0, 2.5, 3.0, 3.5, 4.0};
constexpr double kStep = 0.5;  // between them

}  // namespace

Slide ClosestSlide(const MapModel& map, const ScanGroup& group, const MapRefinement& found,
                   double gate) {
  const double sigma = MeasureMapErrors(found.residuals).sigma;
  const PoseRivals rivals(map, group, found.map_from_group, gate, sigma);
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> axes(found.covariance.topLeftCorner<3, 3>());
  const double step = std::max(gate, MapRefinementOptions().last_gate);
  Slide closest;
  closest.lead = INFINITY;
  for (int axis = 2; axis >= 0; --axis) {
    for (const double gates : kGates) {
      for (const double sign : {-1.0, 1.0}) {
        const Eigen::Vector3d direction = sign * axes.eigenvectors().col(axis);
        const double metres = gates * step;
        const PoseOdds odds = rivals.Compare(metres * direction, 0.5 * kStep * step);
        if (odds.lead >= closest.lead) continue;
        closest = {found.map_from_group, direction, metres, odds.all, odds.lead};
      }
    }
  }
  closest.map_from_group.translation += closest.metres * closest.direction;
  return closest;
}

}  // namespace planegraph
