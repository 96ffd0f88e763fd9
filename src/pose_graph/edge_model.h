#pragma once

#include "planegraph/pose_graph/pose_graph.h"

namespace planegraph {

/// An edge at the graph's poses: residual, its derivatives, and the second derivatives of
/// 0.5 r^T information r that Gauss-Newton leaves out. Unknowns of a pose: x, then theta (or the
/// angle), of the retraction t <- t + R x, R <- R Exp(theta), in the node's own axes.
template <int Dim>
struct EdgeModel {
  static constexpr int kSize = kPoseDimension<Dim>;
  using Vector = Eigen::Matrix<double, kSize, 1>;
  using Matrix = Eigen::Matrix<double, kSize, kSize>;

  Vector residual;
  Matrix by_from, by_to;
  Matrix curvature_from, curvature_to, curvature_cross;  ///< cross: rows from, columns to
};

template <int Dim>
Eigen::Matrix<double, kPoseDimension<Dim>, 1> EdgeResidual(const GraphPose<Dim>& from,
                                                           const GraphPose<Dim>& to,
                                                           const GraphEdge<Dim>& edge,
                                                           RotationResidual kind);

/// With `curvature` false its members are left as they are.
template <int Dim>
void ModelEdge(const GraphPose<Dim>& from, const GraphPose<Dim>& to, const GraphEdge<Dim>& edge,
               RotationResidual kind, bool curvature, EdgeModel<Dim>* model);

/// The retraction.
template <int Dim>
GraphPose<Dim> Retract(const GraphPose<Dim>& pose,
                       const Eigen::Matrix<double, kPoseDimension<Dim>, 1>& step);

/// The nearest rotation (Frobenius norm), of determinant +1.
template <int Dim>
Eigen::Matrix<double, Dim, Dim> NearestRotation(const Eigen::Matrix<double, Dim, Dim>& matrix);

}  // namespace planegraph
