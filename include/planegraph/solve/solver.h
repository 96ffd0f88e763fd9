#pragma once

#include <map>
#include <string>
#include <vector>

#include "planegraph/graph/factor_registry.h"
#include "planegraph/graph/graph.h"
#include "planegraph/graph/loss.h"

namespace planegraph {

/// How the normal equations are solved. kAuto: planes are eliminated first; the reduced system of
/// the poses is dense up to kDenseSchurPoses poses and sparse beyond. Where plane factors tie
/// planes to each other it is always kSparseCholesky.
enum class LinearSolver { kAuto, kDenseSchur, kSparseSchur, kSparseCholesky };

struct SolveOptions {
  std::string plane_factor = "moments";  ///< a plane factor of the registry
  FactorOptions plane_factor_options;
  /// Of every plane residual, and of the pose factors that are marked robust. Graduated ones
  /// (gnc_tls, gnc_gm) are reached in an outer loop from the solution without loss.
  LossSpec plane_loss, pose_loss;
  /// Other losses for factors of some types, by their names; they too are for factors that are
  /// marked robust alone.
  std::map<std::string, LossSpec> factor_losses;
  int max_iterations = 100;
  /// First radius of the trust region. Where weak priors alone (GPS of metres) hold a stiff graph,
  /// the default damps its motion as a whole a thousandfold; a large one lets it go at once.
  double initial_radius = 1e4;
  double function_tolerance = 1e-10, gradient_tolerance = 1e-10, parameter_tolerance = 1e-10;
  /// Threads inside Ceres. Its Schur elimination adds up in the order in which threads arrive, so
  /// that only one thread gives the same bytes in every run.
  int threads = 1;
  LinearSolver linear_solver = LinearSolver::kAuto;
  bool collect_residuals = true;  ///< fill SolveSummary::residuals
};

/// A residual block after the solve.
struct ResidualReport {
  ResidualTag tag;
  int dimension = 0;
  double chi2 = 0.0;    ///< |r|^2, whitened, without loss and weight
  double weight = 1.0;  ///< the loss's rho' times the factor's weight: near 0 is switched off
};

struct SolveSummary {
  bool converged = false;
  bool usable =
      false;  ///< the graph holds a solution (converged, or the last step of the iterations)
  double initial_cost = 0.0, final_cost = 0.0;  ///< 0.5 * sum of weight * rho(|r|^2)
  int iterations = 0;
  int graduated_steps = 0;    ///< of the outer loop, where a loss is graduated
  std::vector<double> costs;  ///< the start's, then of each step that was kept
  int residual_count = 0;     ///< scalar residuals
  int parameter_count = 0;    ///< tangent dimensions that are not fixed
  double seconds = 0.0;       ///< wall time, building included
  std::string message;        ///< of Ceres
  std::string linear_solver;
  std::vector<ResidualReport> residuals;  ///< in the order of planes, observations, pose factors

  /// Redundancy residual_count - parameter_count (2 * final_cost over it is near 1 for honest
  /// weights where all directions are observed).
  int DegreesOfFreedom() const { return residual_count - parameter_count; }
};

/// Moves poses and planes of the graph to the minimum of the sum of their factors
/// (Levenberg-Marquardt by Ceres, planes eliminated by Schur's complement). Gauge: poses marked
/// fixed stay; where none is and no prior is there, the first one stays. A direction that nothing
/// observes is held by the damping and keeps its start. The result is the same to the byte for
/// equal input while threads = 1. Throws UsageError for unknown names and std::invalid_argument for
/// a graph that is not valid.
SolveSummary Solve(Graph* graph, const SolveOptions& options = {});

/// The residuals of the graph as it stands.
std::vector<ResidualReport> EvaluateResiduals(const Graph& graph, const SolveOptions& options = {});

}  // namespace planegraph
