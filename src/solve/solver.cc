#include "planegraph/solve/solver.h"

#include <ceres/ceres.h>

#include <chrono>

#include "solve/assembly.h"

namespace planegraph {
namespace {

// Measured (benchmarks/solve_benchmark.cc, every pair of poses sharing planes): equal at 24 poses,
// dense 1.7 times as fast at 100. Beyond, real sites share planes with neighbours only, and sparse
// wins.
constexpr int kDenseSchurPoses = 100;

struct Manifolds {
  Se3Manifold pose;
  PlaneManifold plane;
  Sim3Manifold map;
};

struct BlockUse {
  std::vector<bool> poses, planes, maps;  // named by a residual

  std::vector<bool>& Of(BlockKind kind) {
    if (kind == BlockKind::kMap) return maps;
    return kind == BlockKind::kPose ? poses : planes;
  }
};

// All objects belong to the assembly and to `Solve`; Ceres gets to delete nothing.
ceres::Problem::Options CheapProblem() {
  ceres::Problem::Options options;
  options.cost_function_ownership = ceres::DO_NOT_TAKE_OWNERSHIP;
  options.loss_function_ownership = ceres::DO_NOT_TAKE_OWNERSHIP;
  options.manifold_ownership = ceres::DO_NOT_TAKE_OWNERSHIP;
  options.disable_all_safety_checks = true;
  return options;
}

BlockUse FindUsedBlocks(const Graph& graph, const Assembly& assembly) {
  BlockUse use{std::vector<bool>(graph.poses.size()), std::vector<bool>(graph.planes.size()),
               std::vector<bool>(graph.maps.size())};
  for (const Residual& residual : assembly.residuals()) {
    for (int k = 0; k < residual.block_count; ++k) {
      use.Of(residual.blocks[k].kind)[residual.blocks[k].index] = true;
    }
  }
  return use;
}

void AddBlocks(const Graph& graph, const BlockUse& use, const Gauge& gauge, Manifolds* manifolds,
               Assembly* assembly, ceres::Problem* problem) {
  for (int i = 0; i < static_cast<int>(graph.poses.size()); ++i) {
    if (!use.poses[i]) continue;
    problem->AddParameterBlock(assembly->PoseBlock(i), kPoseSize, &manifolds->pose);
    if (gauge.poses[i]) problem->SetParameterBlockConstant(assembly->PoseBlock(i));
  }
  for (int m = 0; m < static_cast<int>(graph.maps.size()); ++m) {
    if (!use.maps[m]) continue;
    problem->AddParameterBlock(assembly->MapBlock(m), kMapSize, &manifolds->map);
    if (gauge.maps[m]) problem->SetParameterBlockConstant(assembly->MapBlock(m));
  }
  for (int k = 0; k < static_cast<int>(graph.planes.size()); ++k) {
    if (!use.planes[k]) continue;
    problem->AddParameterBlock(assembly->PlaneBlock(k), kPlaneSize, &manifolds->plane);
  }
}

void AddResiduals(Assembly* assembly, ceres::Problem* problem) {
  for (const Residual& residual : assembly->residuals()) {
    double* blocks[2] = {assembly->Block(residual.blocks[0]), nullptr};
    if (residual.block_count > 1) blocks[1] = assembly->Block(residual.blocks[1]);
    problem->AddResidualBlock(residual.cost.get(), residual.loss, blocks, residual.block_count);
  }
}

ceres::LinearSolverType ChooseSolver(const Graph& graph, const Assembly& assembly,
                                     LinearSolver wanted) {
  if (!assembly.plane_blocks() || wanted == LinearSolver::kSparseCholesky) {
    return ceres::SPARSE_NORMAL_CHOLESKY;
  }
  if (wanted == LinearSolver::kDenseSchur) return ceres::DENSE_SCHUR;
  if (wanted == LinearSolver::kSparseSchur) return ceres::SPARSE_SCHUR;
  return graph.poses.size() <= kDenseSchurPoses ? ceres::DENSE_SCHUR : ceres::SPARSE_SCHUR;
}

// Planes first: no residual joins two of them.
std::shared_ptr<ceres::ParameterBlockOrdering> PlanesFirst(const Graph& graph, const BlockUse& use,
                                                           Assembly* assembly) {
  auto ordering = std::make_shared<ceres::ParameterBlockOrdering>();
  for (int k = 0; k < static_cast<int>(graph.planes.size()); ++k) {
    if (use.planes[k]) ordering->AddElementToGroup(assembly->PlaneBlock(k), 0);
  }
  for (int i = 0; i < static_cast<int>(graph.poses.size()); ++i) {
    if (use.poses[i]) ordering->AddElementToGroup(assembly->PoseBlock(i), 1);
  }
  for (int m = 0; m < static_cast<int>(graph.maps.size()); ++m) {
    // A group of their own: Ceres orders a group's blocks by their addresses, and where maps lie
    // relative to poses is the heap's business, different from run to run.
    if (use.maps[m]) ordering->AddElementToGroup(assembly->MapBlock(m), 2);
  }
  return ordering;
}

ceres::Solver::Options CeresOptions(const SolveOptions& options, ceres::LinearSolverType type) {
  ceres::Solver::Options ceres_options;
  ceres_options.linear_solver_type = type;
  ceres_options.max_num_iterations = options.max_iterations;
  ceres_options.initial_trust_region_radius = options.initial_radius;
  ceres_options.function_tolerance = options.function_tolerance;
  ceres_options.gradient_tolerance = options.gradient_tolerance;
  ceres_options.parameter_tolerance = options.parameter_tolerance;
  ceres_options.num_threads = options.threads;
  ceres_options.logging_type = ceres::SILENT;
  return ceres_options;
}

std::vector<ResidualReport> CollectResiduals(Assembly* assembly) {
  std::vector<ResidualReport> reports;
  reports.reserve(assembly->residuals().size());
  for (const Residual& residual : assembly->residuals()) {
    ResidualReport& report = reports.emplace_back();
    report.tag = residual.tag;
    report.dimension = residual.cost->num_residuals();
    report.chi2 = assembly->Chi2(residual, &report.weight);
  }
  return reports;
}

void Fill(const ceres::Solver::Summary& ceres_summary, SolveSummary* summary) {
  summary->converged = ceres_summary.termination_type == ceres::CONVERGENCE;
  summary->usable = ceres_summary.IsSolutionUsable();
  summary->initial_cost = ceres_summary.initial_cost;
  summary->final_cost = ceres_summary.final_cost;
  summary->iterations = static_cast<int>(ceres_summary.iterations.size()) - 1;
  for (const ceres::IterationSummary& step : ceres_summary.iterations) {
    if (step.iteration == 0 || step.step_is_successful) summary->costs.push_back(step.cost);
  }
  summary->residual_count = ceres_summary.num_residuals;
  summary->parameter_count = ceres_summary.num_effective_parameters_reduced;
  summary->message = ceres_summary.message;
  summary->linear_solver = ceres::LinearSolverTypeToString(ceres_summary.linear_solver_type_used);
}

void Minimize(const Graph& graph, const SolveOptions& options, Assembly* assembly,
              SolveSummary* summary) {
  Manifolds manifolds;
  ceres::Problem problem(CheapProblem());
  const BlockUse use = FindUsedBlocks(graph, *assembly);
  AddBlocks(graph, use, GaugeFixed(graph, true), &manifolds, assembly, &problem);
  AddResiduals(assembly, &problem);
  const ceres::LinearSolverType type = ChooseSolver(graph, *assembly, options.linear_solver);
  ceres::Solver::Options ceres_options = CeresOptions(options, type);
  if (type != ceres::SPARSE_NORMAL_CHOLESKY) {
    ceres_options.linear_solver_ordering = PlanesFirst(graph, use, assembly);
  }
  ceres::Solver::Summary ceres_summary;
  ceres::Solve(ceres_options, &problem, &ceres_summary);
  Fill(ceres_summary, summary);
}

}  // namespace

SolveSummary Solve(Graph* graph, const SolveOptions& options) {
  const auto start = std::chrono::steady_clock::now();
  CheckGraph(*graph);
  Assembly assembly(*graph, options);
  SolveSummary summary;
  Minimize(*graph, options, &assembly, &summary);
  if (summary.usable) {
    assembly.Store(graph);
    // Planes that are no unknowns of the problem follow from the poses.
    if (!assembly.plane_blocks()) {
      for (PlaneLandmark& plane : graph->planes) FitLandmark(*graph, &plane);
    }
  }
  if (options.collect_residuals) summary.residuals = CollectResiduals(&assembly);
  summary.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  return summary;
}

std::vector<ResidualReport> EvaluateResiduals(const Graph& graph, const SolveOptions& options) {
  CheckGraph(graph);
  Assembly assembly(graph, options);
  return CollectResiduals(&assembly);
}

}  // namespace planegraph
