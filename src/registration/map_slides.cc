#include "registration/map_slides.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

namespace planegraph {
namespace {

// The refinement pairs what is within its last gate, so that poses less than two of these apart see
// the same surfaces and end at the same place; walls and roofs are no thicker than four.
constexpr double kGates[] = {2.0, 2.5, 3.0, 3.5, 4.0};
constexpr double kRightInTen = 9.0;

// Surfaces that speak for the pose, less those that speak against it. Where the map does not know
// of free air a miss says nothing.
double Voices(const MapModel& map, const ScanGroup& group, const Sim3& pose, double gate) {
  const MapEvidence e = MeasureSurfaces(map, group, pose, gate);
  return e.surfaces * (e.confirmed - (map.sky().known() ? e.contradicted : 0.0));
}

}  // namespace

Slide ClosestSlide(const MapModel& map, const ScanGroup& group, const MapRefinement& found,
                   double gate) {
  const double best = Voices(map, group, found.map_from_group, gate);
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> axes(found.covariance.topLeftCorner<3, 3>());
  const double step = std::max(gate, MapRefinementOptions().last_gate);
  Slide closest;
  closest.lead = INFINITY;
  for (int axis = 2; axis >= 0; --axis) {
    for (const double gates : kGates) {
      for (const double metres : {-gates * step, gates * step}) {
        Sim3 pose = found.map_from_group;
        pose.translation += metres * axes.eigenvectors().col(axis);
        const double lead = std::log(kRightInTen) * (best - Voices(map, group, pose, gate));
        if (lead < closest.lead) closest = {pose, std::abs(metres), lead};
      }
    }
  }
  return closest;
}

}  // namespace planegraph
