#include "planegraph/solve/solver.h"

#include <ceres/ceres.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <map>
#include <utility>

#include "solve/assembly.h"
#include "solve/group_switch.h"

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
  std::vector<std::unique_ptr<ceres::Manifold>> planes;  // where the plane factor has its own
};

struct BlockUse {
  std::vector<bool> poses, planes, maps, scales;  // named by a residual

  std::vector<bool>& Of(BlockKind kind) {
    if (kind == BlockKind::kMap) return maps;
    if (kind == BlockKind::kScale) return scales;
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
               std::vector<bool>(graph.maps.size()), std::vector<bool>(graph.scales.size())};
  for (const Residual& residual : assembly.residuals()) {
    for (const BlockRef& block : residual.blocks) use.Of(block.kind)[block.index] = true;
  }
  return use;
}

void AddPlaneBlocks(const Graph& graph, const SolveOptions& options, const BlockUse& use,
                    Manifolds* manifolds, Assembly* assembly, ceres::Problem* problem) {
  const FactorType& type = BuiltinFactors().Get(options.plane_factor, FactorKind::kPlane);
  for (int k = 0; k < static_cast<int>(graph.planes.size()); ++k) {
    if (!use.planes[k]) continue;
    ceres::Manifold* manifold = &manifolds->plane;
    if (type.make_manifold) {
      manifolds->planes.push_back(
          type.make_manifold(graph.planes[k], options.plane_factor_options));
      manifold = manifolds->planes.back().get();
    }
    problem->AddParameterBlock(assembly->PlaneBlock(k), kPlaneSize, manifold);
  }
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
  for (int s = 0; s < static_cast<int>(graph.scales.size()); ++s) {
    if (use.scales[s]) problem->AddParameterBlock(assembly->ScaleBlock(s), 1);
  }
}

void AddResiduals(Assembly* assembly, ceres::Problem* problem) {
  for (const Residual& residual : assembly->residuals()) {
    std::vector<double*> blocks;
    for (const BlockRef& block : residual.blocks) blocks.push_back(assembly->Block(block));
    problem->AddResidualBlock(residual.cost.get(), residual.loss, blocks);
  }
}

ceres::LinearSolverType ChooseSolver(const Graph& graph, const Assembly& assembly,
                                     LinearSolver wanted) {
  // What ties two planes: they cannot all be eliminated one by one. Without planes nothing can.
  const bool tied = !graph.plane_factors.empty() || graph.planes.empty();
  if (!assembly.plane_blocks() || tied || wanted == LinearSolver::kSparseCholesky) {
    return ceres::SPARSE_NORMAL_CHOLESKY;
  }
  if (wanted == LinearSolver::kDenseSchur) return ceres::DENSE_SCHUR;
  if (wanted == LinearSolver::kSparseSchur) return ceres::SPARSE_SCHUR;
  // Tiles of maps hang together by neighbours only, as poses do.
  const auto ties = std::count_if(graph.map_factors.begin(), graph.map_factors.end(),
                                  [](const MapFactor& factor) { return factor.maps.size() == 2; });
  const std::size_t nodes = graph.poses.size() + static_cast<std::size_t>(ties) / 2;
  return nodes <= kDenseSchurPoses ? ceres::DENSE_SCHUR : ceres::SPARSE_SCHUR;
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
  for (int s = 0; s < static_cast<int>(graph.scales.size()); ++s) {
    if (use.scales[s]) ordering->AddElementToGroup(assembly->ScaleBlock(s), 3);
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

// Of the first solve the initial cost, of the last one all else.
void Fill(const ceres::Solver::Summary& ceres_summary, SolveSummary* summary) {
  if (summary->residual_count == 0) summary->initial_cost = ceres_summary.initial_cost;
  summary->converged = ceres_summary.termination_type == ceres::CONVERGENCE;
  summary->usable = ceres_summary.IsSolutionUsable();
  summary->final_cost = ceres_summary.final_cost;
  summary->iterations += static_cast<int>(ceres_summary.iterations.size()) - 1;
  for (const ceres::IterationSummary& step : ceres_summary.iterations) {
    if (step.iteration == 0 || step.step_is_successful) summary->costs.push_back(step.cost);
  }
  summary->residual_count = ceres_summary.num_residuals;
  summary->parameter_count = ceres_summary.num_effective_parameters_reduced;
  summary->message = ceres_summary.message;
  summary->linear_solver = ceres::LinearSolverTypeToString(ceres_summary.linear_solver_type_used);
}

// The problem as Ceres has it, for one solve or several under changing weights.
class Minimizer {
 public:
  Minimizer(const Graph& graph, const SolveOptions& options, Assembly* assembly)
      : graph_(graph),
        assembly_(assembly),
        problem_(CheapProblem()),
        use_(FindUsedBlocks(graph, *assembly)) {
    AddBlocks(graph, use_, GaugeFixed(graph, true), &manifolds_, assembly, &problem_);
    AddPlaneBlocks(graph, options, use_, &manifolds_, assembly, &problem_);
    AddResiduals(assembly, &problem_);
    const auto& residuals = assembly->residuals();
    hidden_planes_ =
        static_cast<int>(std::count_if(residuals.begin(), residuals.end(), HidesPlane));
  }

  void Run(const SolveOptions& options, SolveSummary* summary) {
    const ceres::LinearSolverType type = ChooseSolver(graph_, *assembly_, options.linear_solver);
    ceres::Solver::Options ceres_options = CeresOptions(options, type);
    if (type != ceres::SPARSE_NORMAL_CHOLESKY) {
      ceres_options.linear_solver_ordering = PlanesFirst(graph_, use_, assembly_);
    }
    ceres::Solver::Summary ceres_summary;
    ceres::Solve(ceres_options, &problem_, &ceres_summary);
    Fill(ceres_summary, summary);
    summary->parameter_count += hidden_planes_ * kPlaneTangent;
  }

 private:
  const Graph& graph_;
  Assembly* assembly_;
  Manifolds manifolds_;  // outlives the problem
  ceres::Problem problem_;
  BlockUse use_;
  int hidden_planes_ = 0;
};

// The outer loop of the graduated losses: planes and measurements have schedules of their own, one
// for each kernel. All chi2 are relative to their limits, so that 1 is the scale of each.
class Graduation {
 public:
  explicit Graduation(Assembly* assembly) {
    for (const SwitchGroup& group : assembly->switch_groups()) {
      const Residual& first = assembly->residuals()[group.residuals.front()];
      const bool is_plane = first.tag.plane >= 0 || first.tag.plane_factor >= 0;
      const GncKernel kernel = KernelOf(*group.loss);
      Course& course = courses_.try_emplace({is_plane, kernel}, kernel).first->second;
      course.switches.emplace_back(group, assembly);
    }
    Measure();
    for (auto& [key, course] : courses_) course.schedule.Start(course.chi2);
  }

  bool Finished() const {
    return std::all_of(courses_.begin(), courses_.end(),
                       [](const auto& entry) { return entry.second.schedule.Finished(); });
  }

  void SetWeights(bool final) {
    for (auto& [key, course] : courses_) {
      const GncSchedule& schedule = course.schedule;
      for (const GroupSwitch& group : course.switches) {
        group.SetWeights([&](double chi2) {
          return final ? schedule.FinalWeight(chi2) : schedule.Weight(chi2);
        });
      }
    }
  }

  void Advance() {
    Measure();
    for (auto& [key, course] : courses_) {
      if (!course.schedule.Finished()) course.schedule.Advance(course.chi2);
    }
  }

  void Measure() {
    for (auto& [key, course] : courses_) {
      course.chi2.clear();
      for (GroupSwitch& group : course.switches) group.Measure(&course.chi2);
    }
  }

 private:
  struct Course {
    explicit Course(GncKernel kernel) : schedule(kernel, 1.0) {}
    GncSchedule schedule;
    std::vector<GroupSwitch> switches;
    std::vector<double> chi2;  // as the schedule wants them
  };
  std::map<std::pair<bool, GncKernel>, Course> courses_;
};

void MinimizeGraduated(const SolveOptions& options, Assembly* assembly, Minimizer* minimizer,
                       SolveSummary* summary) {
  // A surrogate's solution is but the next one's start.
  SolveOptions quick = options;
  quick.max_iterations = std::min(options.max_iterations, 10);
  quick.function_tolerance = std::max(options.function_tolerance, 1e-4);
  minimizer->Run(quick, summary);
  Graduation graduation(assembly);
  for (; !graduation.Finished(); ++summary->graduated_steps) {
    graduation.SetWeights(false);
    minimizer->Run(quick, summary);
    graduation.Advance();
  }
  // Weights of the robust cost itself, until none of them changes the solution any more.
  constexpr int kMostLastSteps = 10;
  for (int step = 0; step < kMostLastSteps; ++step) {
    graduation.Measure();
    graduation.SetWeights(true);
    const double before = summary->final_cost;
    minimizer->Run(options, summary);
    if (std::abs(summary->final_cost - before) <= 1e-6 * before) break;
  }
}

}  // namespace

SolveSummary Solve(Graph* graph, const SolveOptions& options) {
  const auto start = std::chrono::steady_clock::now();
  CheckGraph(*graph);
  Assembly assembly(*graph, options);
  SolveSummary summary;
  Minimizer minimizer(*graph, options, &assembly);
  if (assembly.switch_groups().empty()) {
    minimizer.Run(options, &summary);
  } else {
    MinimizeGraduated(options, &assembly, &minimizer, &summary);
  }
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
