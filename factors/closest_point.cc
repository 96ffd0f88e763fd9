// Plane landmark by its closest point to a reference point, CP = d n (Geneva, Eckenhoff, Yang,
// Huang 2018), predicted less measured:
//
//   r = W ((g + D n' . n_m) n' - D n_m)      n' = R^T n,  g = e + n . (o - t) - s n' . c
//
// (s, R, t): world_from_node, s = 1 for a pose; n_m, c: the segment's normal and centroid (node's
// frame); n, e: the landmark's normal and its offset from the anchor o; g: distance of the centroid
// from the landmark (m of the world); W: tilt weights over D along the in-plane axes, the offset's
// along n_m.
//
// The reference lies at c - D n_m, beside the patch, and not at the node's origin as published: the
// closest point is singular for planes through the reference, which in a drone map's frame nothing
// prevents (no sensor stands at its origin), and far from it offset and tilt couple, by d tilt^2 in
// the offset. Of second order are left g / D of a tilt and D tilt^2 of an offset: at the size of
// the noise they weigh the same for D = sigma of the offset / sigma of the tilts, where the closest
// point's covariance is a sphere. The landmark steps in the same way, by its closest point to a
// reference as far beside it (ClosestPointManifold).
#include <algorithm>
#include <cmath>

#include "factors/plane_in_node.h"
#include "planegraph/graph/plane_charts.h"

namespace planegraph {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

// Metres; 1 where an observation lacks a weight.
double ReferenceDistance(double tilt_weight_1, double tilt_weight_2, double offset_weight) {
  const double tilt = std::sqrt(tilt_weight_1 * tilt_weight_2);
  return tilt > 0.0 && offset_weight > 0.0 ? tilt / offset_weight : 1.0;
}

// The farthest of the observations': the longest steps.
double ReferenceDistance(const PlaneLandmark& plane) {
  double distance = 0.0;
  for (const PlaneObservation& seen : plane.observations) {
    distance = std::max(
        distance, ReferenceDistance(seen.tilt_weight_1, seen.tilt_weight_2, seen.offset_weight));
  }
  return distance;
}

class ClosestPoint {
 public:
  ClosestPoint(const MeasuredPlane& m, const FactorOptions&) : centroid_(m.centroid) {
    const double distance = ReferenceDistance(m.tilt_weight_1, m.tilt_weight_2, m.offset_weight);
    measured_ = distance * m.normal;
    whitening_ << m.tilt_weight_1 / distance * m.axis_1.transpose(),
        m.tilt_weight_2 / distance * m.axis_2.transpose(), m.offset_weight * m.normal.transpose();
  }

  PlaneComparison operator()(const Vector3d& n, double d, double scale) const {
    const Vector3d arm = scale * centroid_;
    const double distance = d - n.dot(arm) + n.dot(measured_);
    const Vector3d along = whitening_ * n;
    const Matrix3d by_normal = distance * whitening_ + along * measured_.transpose();
    return CompareAtCentroid(distance * along - whitening_ * measured_, by_normal, along, n, arm);
  }

 private:
  Vector3d centroid_, measured_;  // node's units; closest point about the reference, metres
  Matrix3d whitening_;
};

}  // namespace

void Register_closest_point(FactorRegistry* registry) {
  FactorType type;
  type.name = "closest_point";
  type.description = "plane landmark by its closest point to a reference beside the patch";
  type.source =
      "Geneva, Eckenhoff, Yang, Huang: LIPS: LiDAR-inertial 3D plane SLAM, IROS 2018; reference "
      "moved beside the patch (own)";
  type.residual =
      "closest point of the landmark's plane to the reference less the measured one (m of the "
      "world, node's axes), along in-plane axis 1 and 2 and the normal, whitened";
  type.make_manifold = [](const PlaneLandmark& plane, const FactorOptions&) {
    const double beside = ReferenceDistance(plane) - plane.offset;
    return std::make_unique<ClosestPointManifold>(beside * plane.normal);
  };
  RegisterPlaneInNode<ClosestPoint>(std::move(type), registry);
}

}  // namespace planegraph
