// Plane landmark against the measured normal and offset with their covariance (the form that plane
// graphs mostly use, for example Weingarten and Siegwart 2006, Trevor et al. 2012):
//
//   r = L [ v_1 . n' ; v_2 . n' ; d' - s n_m . c ]       n' = R^T n,  d' = e + n . (o - t)
//
// v_1, v_2: the segment's in-plane axes, n_m, c: its normal and centroid (node's frame); (s, R, t):
// world_from_node, s = 1 for a pose; n, e: the landmark's normal and its offset from the anchor o.
// L^T L is the information of tilt and offset carried to the node's origin, with their correlation:
// to first order the cost is that of `moments`. It differs in the second order, by d (1 - cos tilt)
// in the offset: far from the node's origin a turn costs more than the points say.
#include "factors/plane_in_node.h"

namespace planegraph {
namespace {

class NormalOffset {
 public:
  NormalOffset(const MeasuredPlane& measured, const FactorOptions&) : m_(measured) {
    by_normal_ = m_.root.col(0) * m_.axis_1.transpose() + m_.root.col(1) * m_.axis_2.transpose();
  }

  PlaneComparison operator()(const Eigen::Vector3d& n, double d, double scale) const {
    const double measured = scale * m_.distance;
    return {by_normal_ * n + m_.root.col(2) * (d - measured), by_normal_, m_.root.col(2),
            -measured * m_.root.col(2)};
  }

 private:
  MeasuredPlane m_;
  Eigen::Matrix3d by_normal_;
};

}  // namespace

void Register_normal_offset(FactorRegistry* registry) {
  FactorType type;
  type.name = "normal_offset";
  type.description = "plane landmark by normal and offset with their covariance";
  type.residual =
      "normal along in-plane axis 1 and 2 (rad, node's frame) and distance from the node's origin "
      "(m of the world) against the measured ones, whitened by their joint covariance";
  RegisterPlaneInNode<NormalOffset>(std::move(type), 0.0, registry);
}

}  // namespace planegraph
