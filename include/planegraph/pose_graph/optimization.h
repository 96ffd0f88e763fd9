#pragma once

#include <vector>

#include "planegraph/graph/loss.h"
#include "planegraph/pose_graph/pose_graph.h"

namespace planegraph {

struct PoseGraphOptions {
  int max_iterations = 500;
  /// Converged where a Newton step promises to lower the cost by less than this fraction of it; the
  /// step is taken, and what is left is of that fraction's square. Where Gauss-Newton serves
  /// (robust losses), what its rate of convergence leaves behind must be below 1e-4 of this. At
  /// rest is also a graph where a step gains less than 1e-16 for each edge.
  double tolerance = 1e-7;
  bool near_minimum = false;    ///< begin with Newton's step
  LossSpec loss;                ///< of the edges that are marked robust
  std::vector<double> weights;  ///< of each edge, from outside (graduated non-convexity); empty: 1
};

struct PoseGraphSummary {
  bool converged = false;
  double initial_cost = 0.0, final_cost = 0.0;  ///< 0.5 * sum of weight * rho(r^T information r)
  int iterations = 0;                           ///< steps that were taken
  int factorizations = 0;
  double seconds = 0.0;  ///< wall time
};

/// Moves the graph's poses to a minimum of its cost near the start: Newton's method with the exact
/// second derivatives where they are positive definite, else Gauss-Newton, damped (Levenberg and
/// Marquardt) where a step does not lower the cost; normal equations by sparse block Cholesky.
/// Poses marked fixed stay; in a part of the graph without one its first pose stays. Deterministic.
/// Throws std::invalid_argument for indices out of range or weights of the wrong count.
template <int Dim>
PoseGraphSummary OptimizePoseGraph(PoseGraph<Dim>* graph, const PoseGraphOptions& options = {});

/// Poses from the relative poses alone ("chordal", Carlone et al. 2015, after Martinec and Pajdla
/// 2007): rotations by linear least squares over all matrices, projected to rotations, then
/// translations by linear least squares. Weights are the isotropic ones of each edge's information.
/// Fixed poses stay, as above; all poses do where the edges do not determine them numerically.
template <int Dim>
void InitializeChordal(PoseGraph<Dim>* graph);

/// The same from the edges that are not marked robust (odometry), where these alone tie the poses
/// together as all edges do; else from all of them. One false loop closure bends a chordal start.
template <int Dim>
void InitializeChordalFromTrusted(PoseGraph<Dim>* graph);

/// For each pose the index of the lowest pose that edges connect it with.
template <int Dim>
std::vector<int> ConnectedParts(const PoseGraph<Dim>& graph);

/// Marks fixed poses, and the first pose of each part of the graph that has none.
template <int Dim>
std::vector<bool> GaugeOf(const PoseGraph<Dim>& graph);

}  // namespace planegraph
