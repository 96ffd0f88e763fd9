#pragma once

#include <vector>

#include "planegraph/pose_graph/pose_graph.h"

namespace planegraph {

/// Whether a stationary point of the isotropic problem is its global minimum.
struct Certificate {
  bool certified = false;
  double objective = 0.0;  ///< F = sum kappa |R_to - R_from Z|^2 + tau |t_to - t_from - R_from z|^2
  /// F minus this is a lower bound of F over all poses. It is at most kCertifiedGap of F where
  /// `certified`.
  double suboptimality_bound = 0.0;
  /// Where not certified: the direction of most negative curvature of the dual, one row a pose and
  /// `Dim` + 1 columns, first of the rotation, then of the translation; and its curvature.
  Eigen::MatrixXd direction;
  double curvature = 0.0;
};

/// Relative gap up to which a minimum counts as the global one.
inline constexpr double kCertifiedGap = 1e-6;

/// The dual certificate of SE-Sync (Rosen et al. 2019; ALGORITHMS 6.12) with the translations kept,
/// by sparse Cholesky factorizations alone: S(Lambda) + eta I >= 0 on the rotations bounds F from
/// below by F - Dim * poses * eta. For graphs whose informations are IsotropicInformation(), whose
/// rotation residual is kHalfSine and of which at most one pose is fixed; std::invalid_argument
/// otherwise. The poses must be a minimum (OptimizePoseGraph); the further they are from one, the
/// worse the bound. A part of the graph that no edge ties to the rest is certified with it.
template <int Dim>
Certificate Certify(const PoseGraph<Dim>& graph);

}  // namespace planegraph
