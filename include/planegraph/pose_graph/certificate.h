#pragma once

#include <vector>

#include "planegraph/pose_graph/optimization.h"
#include "planegraph/pose_graph/pose_graph.h"

namespace planegraph {

/// Whether a minimum of the isotropic problem is its global one.
struct Certificate {
  bool certified = false;
  /// F = sum kappa |R_to - R_from Z|^2 + tau |t_to - t_from - R_from z|^2
  double objective = 0.0;
  /// F minus this is a lower bound of F over all poses. It is at most kCertifiedGap of F where
  /// `certified`, or F itself where that is below 1e-16 for each edge.
  double suboptimality_bound = 0.0;
  /// Where not certified: a direction of negative curvature of the dual, one row a pose and `Dim` +
  /// 1 columns, first of the rotation, then of the translation. Empty where none was found.
  Eigen::MatrixXd direction;
};

/// Relative gap up to which a minimum counts as the global one.
inline constexpr double kCertifiedGap = 1e-6;

/// The dual certificate of SE-Sync (Rosen et al. 2019; ALGORITHMS 6.12) with the translations kept,
/// by sparse Cholesky factorizations alone: where S(Lambda) + eta I, eta on the rotations, is
/// positive semi-definite, F is nowhere below its value here by more than Dim * poses * eta. For
/// graphs whose informations are IsotropicInformation(), whose rotation residual is kHalfSine and
/// of which at most one pose is fixed; std::invalid_argument otherwise. The poses must be a minimum
/// (OptimizePoseGraph); the further they are from one, the worse the bound. Parts of the graph that
/// no edge ties to each other are certified together.
template <int Dim>
Certificate Certify(const PoseGraph<Dim>& graph);

struct CertifiedSummary {
  PoseGraphSummary optimization;  ///< of all descents, the first one included
  Certificate certificate;        ///< of the poses that were found
  int escapes = 0;                ///< local minima that were left
  double seconds_certificate = 0.0;
};

/// OptimizePoseGraph, then Certify. Where the certificate fails the poses are a local minimum: the
/// problem is lifted to one more dimension, where its direction of negative curvature leads down,
/// minimized there and rounded back (Riemannian staircase, Boumal et al. 2016), then certified
/// again. The best poses that were seen stay.
template <int Dim>
CertifiedSummary OptimizeCertified(PoseGraph<Dim>* graph);

/// The same without the first descent, for poses that OptimizePoseGraph has left: further Newton
/// steps where the minimum is not exact enough for the proof, and the staircase. `optimization` is
/// of these steps alone; without one its costs and counts are zero.
template <int Dim>
CertifiedSummary CertifyMinimum(PoseGraph<Dim>* graph);

}  // namespace planegraph
