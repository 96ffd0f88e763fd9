#pragma once

#include <Eigen/Core>
#include <vector>

namespace planegraph {

/// Pose graphs by themselves: poses and relative poses, in space (Dim = 3) and in the plane (2).

/// Unknowns of a pose: translation, then rotation.
template <int Dim>
inline constexpr int kPoseDimension = Dim == 3 ? 6 : 3;

/// world_from_node: x_world = rotation * x_node + translation, metres.
template <int Dim>
struct GraphPose {
  Eigen::Matrix<double, Dim, Dim> rotation = Eigen::Matrix<double, Dim, Dim>::Identity();
  Eigen::Matrix<double, Dim, 1> translation = Eigen::Matrix<double, Dim, 1>::Zero();
};

template <int Dim>
using PoseInformation = Eigen::Matrix<double, kPoseDimension<Dim>, kPoseDimension<Dim>>;

/// The rotation part of an edge's residual, for E = measured^T * estimated of angle a:
/// kHalfSine: the vector part of E's quaternion (its norm is sin |a/2|; in the plane sin(a/2));
/// kAngle: the angle a in (-pi, pi], in the plane alone (g2o's planar edges).
enum class RotationResidual { kHalfSine, kAngle };

/// A measured from_from_to. Its residual is, with d = R_from^T (t_to - t_from) and the measurement
/// (Z, z),
///
///   r = [ Z^T (d - z) ; rotation part of Z^T R_from^T R_to ]
///
/// which is g2o's. `information` belongs to r: metres^-2 and the rotation part's unit.
template <int Dim>
struct GraphEdge {
  int from = 0, to = 0;  ///< indices in PoseGraph::poses
  GraphPose<Dim> measurement;
  PoseInformation<Dim> information = PoseInformation<Dim>::Identity();
  bool robust = false;  ///< takes the robust loss: loop closures, not odometry
};

template <int Dim>
struct PoseGraph {
  std::vector<GraphPose<Dim>> poses;
  std::vector<bool> fixed;  ///< as long as `poses`
  std::vector<GraphEdge<Dim>> edges;
  RotationResidual rotation_residual = RotationResidual::kHalfSine;
};

using PoseGraph2 = PoseGraph<2>;
using PoseGraph3 = PoseGraph<3>;

/// r^T information r of one edge under the graph's poses.
template <int Dim>
double EdgeChi2(const PoseGraph<Dim>& graph, const GraphEdge<Dim>& edge);

/// 0.5 * sum of EdgeChi2.
template <int Dim>
double GraphCost(const PoseGraph<Dim>& graph);

/// Weights that are equal in all directions, after SE-Sync (Rosen et al. 2019): translation
/// tau = Dim / tr(information_t^-1), rotation kappa = 3 / (2 tr(information_r^-1)) in space, the
/// angle's own information in the plane.
template <int Dim>
struct IsotropicWeights {
  double tau = 0.0, kappa = 0.0;
};
template <int Dim>
IsotropicWeights<Dim> IsotropicWeightsOf(const PoseInformation<Dim>& information);

/// The information of kHalfSine for these weights: r^T information r is then exactly
/// kappa |R_to - R_from Z|_F^2 + tau |t_to - t_from - R_from z|^2.
template <int Dim>
PoseInformation<Dim> IsotropicInformation(const IsotropicWeights<Dim>& weights);

}  // namespace planegraph
