#pragma once

#include <utility>
#include <vector>

#include "planegraph/graph/graph.h"
#include "planegraph/solve/solver.h"

namespace planegraph {

/// What a graph says of two of its poses, as a relative pose at the optimum.
struct MarginalEdge {
  int target = 0, source = 0;
  Rigid3 target_from_source;
  /// 6x6 in the project's convention (decoupled left perturbation, target's axes, m and rad), from
  /// the planes that both poses see, the planes marginalized, and the pose factors between the two.
  /// May be rank-deficient.
  Matrix6d information = Matrix6d::Zero();
};

/// Edges for the given (target, source) pairs. A plane seen by k poses of which p pairs are listed
/// enters each with weight min(1, (k - 1) / p): with all pairs that is the 2/k of ALGORITHMS 6.3,
/// so that its information is counted once. The measurements are the relative poses of the graph as
/// it stands: a pose graph of these edges has its minimum there.
std::vector<MarginalEdge> MarginalEdges(const Graph& graph,
                                        const std::vector<std::pair<int, int>>& pairs,
                                        const SolveOptions& options = {});

/// The information matrix that g2o's EDGE_SE3:QUAT wants for an edge target -> source. Its error is
/// that of Z^-1 (X_target^-1 X_source): translation and vector part of the quaternion (half the
/// angle), both in the axes of the source. With e = (R_Z^T x, R_Z^T r / 2): omega = D^T information
/// D, D = diag(R_Z, 2 R_Z).
Matrix6d G2oInformation(const Rigid3& target_from_source, const Matrix6d& information);
/// The inverse of it.
Matrix6d InformationFromG2o(const Rigid3& target_from_source, const Matrix6d& omega);

}  // namespace planegraph
