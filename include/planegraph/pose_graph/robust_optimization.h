#pragma once

#include <vector>

#include "planegraph/graph/gnc.h"
#include "planegraph/pose_graph/optimization.h"

namespace planegraph {

struct GncOptions {
  GncKernel kernel = GncKernel::kTruncated;
  /// Largest norm of an inlier's whitened residual, in sigmas; 0: the 99 % quantile of chi with the
  /// residual's degrees of freedom (3.37 in the plane, 4.10 in space). Where the edges that this
  /// keeps show far less noise than they claim, the run is made again with a bound by the noise
  /// that they show (its quantile for one in a million): odometry that claims to be loose
  /// contradicts no group of false closures that support each other.
  double scale = 0.0;
  int max_rounds = 100;
};

struct GncSummary {
  PoseGraphSummary last;  ///< of the last round; iterations, factorizations, seconds of all
  int rounds = 0;
  double scale = 0.0;           ///< the bound that was used
  std::vector<double> weights;  ///< of each edge, in [0, 1]; 1 for those that are not robust
  /// 0.5 * sum of min(r^T information r, scale^2) or Geman and McClure's over the robust edges,
  /// plus the others' costs.
  double robust_cost = 0.0;
};

/// Graduated non-convexity over the edges that are marked robust (loop closures); the others keep
/// weight 1 and hold the graph together. Starts at the graph's poses.
template <int Dim>
GncSummary OptimizeByGnc(PoseGraph<Dim>* graph, const GncOptions& options = {});

}  // namespace planegraph
