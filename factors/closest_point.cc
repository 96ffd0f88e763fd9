// Plane landmark by the closest point to the node's origin, CP = d n (Geneva, Eckenhoff, Yang,
// Huang 2018), predicted less measured:
//
//   r = W (d' n' - s d n_m)      n' = R^T n,  d' = e + n . (o - t),  d = n_m . c
//
// (s, R, t): world_from_node, s = 1 for a pose; n_m, c: the segment's normal and centroid (node's
// frame); n, e: the landmark's normal and its offset from the anchor o. W carries the information
// of tilt and offset over dCP = n dd + d dn, frozen at the measurement. For d -> 0 that has no
// limit: |d| is taken as the sigma of the offset at least, and planes near the node's origin hold
// less than they could. The landmark steps by the closest point to the world's origin
// (ClosestPointManifold).
#include <cmath>

#include "factors/plane_in_node.h"
#include "planegraph/graph/plane_charts.h"

namespace planegraph {
namespace {

class ClosestPoint {
 public:
  ClosestPoint(const MeasuredPlane& measured, const FactorOptions&) {
    const double d = measured.scale * measured.distance;
    const double lever = std::copysign(std::max(std::abs(d), measured.offset_sigma), d);
    Eigen::Matrix3d to_tilt_and_offset;
    to_tilt_and_offset << measured.axis_1.transpose() / lever, measured.axis_2.transpose() / lever,
        measured.normal.transpose();
    whitening_ = measured.root * to_tilt_and_offset;
    measured_ = measured.distance * (whitening_ * measured.normal);
  }

  PlaneComparison operator()(const Eigen::Vector3d& n, double d, double scale) const {
    const Eigen::Vector3d along = whitening_ * n;
    return {d * along - scale * measured_, d * whitening_, along, -scale * measured_};
  }

 private:
  Eigen::Matrix3d whitening_;
  Eigen::Vector3d measured_;
};

}  // namespace

void Register_closest_point(FactorRegistry* registry) {
  FactorType type;
  type.name = "closest_point";
  type.description = "plane landmark by its closest point to the node's origin";
  type.residual =
      "closest point of the landmark's plane to the node's origin less the measured one (m of the "
      "world, node's axes), whitened; weak for planes through that origin";
  type.make_manifold = [](const Eigen::Vector3d& anchor, const FactorOptions&) {
    return std::make_unique<ClosestPointManifold>(anchor);
  };
  RegisterPlaneInNode<ClosestPoint>(std::move(type), 0.0, registry);
}

}  // namespace planegraph
