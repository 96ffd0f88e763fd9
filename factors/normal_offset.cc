// Plane landmark against the measured normal and offset with their covariance (the form that plane
// graphs mostly use, for example Weingarten and Siegwart 2006, Trevor et al. 2012):
//
//   r = L [ v_1 . n' ; v_2 . n' ; d' - s n_m . c ]       n' = R^T n,  d' = e + n . (o - t)
//
// v_1, v_2: the segment's in-plane axes, n_m, c: its normal and centroid (node's frame); (s, R, t):
// world_from_node, s = 1 for a pose; n, e: the landmark's normal and its offset from the anchor o.
// L^T L is the information of tilt and offset carried to the node's origin, with their correlation:
// to first order the cost is that of `moments`. It differs in the second order, by d (1 - cos tilt)
// in the offset, always towards the node's origin: an error of tilt of 3 degrees at 20 m counts
// like 3 cm, and its mean does not vanish. Drone maps with their rough patches so lose some of
// their scale (hybrid-site-a, short run: 0.08 %, three sigmas); between laser scans it is nothing.
#include "factors/plane_in_node.h"

namespace planegraph {
namespace {

class NormalOffset {
 public:
  NormalOffset(const MeasuredPlane& m, const FactorOptions&)
      : measured_(m.normal.dot(m.centroid)), by_distance_(0.0, 0.0, m.offset_weight) {
    by_normal_.row(0) = m.tilt_weight_1 * m.axis_1;
    by_normal_.row(1) = m.tilt_weight_2 * m.axis_2;
    // The offset at the centroid, carried to the node's origin.
    const Eigen::Vector3d arm = m.scale * m.centroid;
    by_normal_.row(2) =
        -m.offset_weight * (arm.dot(m.axis_1) * m.axis_1 + arm.dot(m.axis_2) * m.axis_2);
  }

  PlaneComparison operator()(const Eigen::Vector3d& n, double d, double scale) const {
    const double measured = scale * measured_;
    return {by_normal_ * n + (d - measured) * by_distance_, by_normal_, by_distance_,
            -measured * by_distance_};
  }

 private:
  double measured_;
  Eigen::Vector3d by_distance_;
  Eigen::Matrix3d by_normal_;
};

}  // namespace

void Register_normal_offset(FactorRegistry* registry) {
  FactorType type;
  type.name = "normal_offset";
  type.description = "plane landmark by normal and offset with their covariance";
  type.source =
      "Weingarten and Siegwart: 3D SLAM using planar segments, IROS 2006; Trevor, Rogers, "
      "Christensen: Planar surface SLAM with 3D and 2D sensors, ICRA 2012";
  type.residual =
      "normal along in-plane axis 1 and 2 (rad, node's frame) and distance from the node's origin "
      "(m of the world) against the measured ones, whitened by their joint covariance";
  RegisterPlaneInNode<NormalOffset>(std::move(type), registry);
}

}  // namespace planegraph
