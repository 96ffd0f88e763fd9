// closures_table GRAPH.g2o: false loop closures added to an SE(3) graph, and what becomes of its
// trajectory, as a Markdown table.
// closures_table GRAPH.g2o KIND SHARE SEED OUT.g2o: writes one of these graphs.
//
// The yardstick is the error that the clean graph's own optimum has. A graph without known truth
// gives it by a parametric bootstrap: its optimum is taken for the truth and every edge measured
// anew, with the noise that the residuals show; the error of these graphs' optima is that of the
// clean one. "Error" is ATE (rmse of positions after alignment by SE(3)).
#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <iterator>
#include <string>
#include <vector>

#include "planegraph/base/error.h"
#include "planegraph/evaluation/trajectory_error.h"
#include "planegraph/geometry/rotation.h"
#include "planegraph/pose_graph/g2o_conversion.h"
#include "planegraph/pose_graph/robust_optimization.h"
#include "planegraph/simulation/random.h"
#include "posegraph/false_closures.h"
#include "report_errors.h"
#include "thread_seconds.h"

namespace planegraph {
namespace {

constexpr int kSeeds = 2, kBootstraps = 10;
const double kShares[] = {0.1, 0.5, 1.0};
const char* const kKinds[] = {"random", "lookalike", "groups"};

double TrajectoryError(const PoseGraph3& truth, const PoseGraph3& graph) {
  PosePairs pairs;
  for (std::size_t i = 0; i < truth.poses.size(); ++i) {
    pairs.reference.push_back({truth.poses[i].rotation, truth.poses[i].translation});
    pairs.estimate.push_back({graph.poses[i].rotation, graph.poses[i].translation});
  }
  return ComputeAte(pairs, PoseAlignment::kSe3).errors.translation.rmse;
}

// The edges of the graph as they would be measured at its poses with `sigma` times the noise that
// their information claims.
PoseGraph3 MeasuredAnew(const PoseGraph3& truth, double sigma, std::uint64_t seed) {
  Random random(seed);
  PoseGraph3 graph = truth;
  for (GraphEdge<3>& edge : graph.edges) {
    const GraphPose<3>&from = truth.poses[edge.from], &to = truth.poses[edge.to];
    Eigen::Matrix<double, 6, 1> noise;
    for (double& value : noise) value = sigma * random.Normal();
    noise = edge.information.llt().matrixU().solve(noise);
    // The residual's rotation is half an angle, and both its parts are seen in the measured frame.
    const Eigen::Matrix3d turn = ExpSO3(2.0 * noise.tail<3>()).toRotationMatrix();
    edge.measurement.rotation = from.rotation.transpose() * to.rotation * turn;
    edge.measurement.translation = from.rotation.transpose() * (to.translation - from.translation) +
                                   edge.measurement.rotation * noise.head<3>();
  }
  return graph;
}

PoseGraph3 Solved(PoseGraph3 graph) {
  InitializeChordal(&graph);
  OptimizePoseGraph(&graph);
  return graph;
}

// By the residuals: chi-square over the degrees of freedom is the square of the factor of sigma.
double CleanError(const PoseGraph3& clean) {
  const double freedom = 6.0 * (static_cast<double>(clean.edges.size()) -
                                static_cast<double>(clean.poses.size()) + 1.0);
  const double sigma = std::sqrt(2.0 * GraphCost(clean) / freedom);
  double sum = 0.0;
  for (int seed = 0; seed < kBootstraps; ++seed) {
    sum += TrajectoryError(clean, Solved(MeasuredAnew(clean, sigma, seed))) / kBootstraps;
  }
  std::printf("The clean optimum: noise %.2f of what the file claims, error %.3f m.\n\n", sigma,
              sum);
  return sum;
}

struct Row {
  std::vector<double> errors, seconds;
  std::size_t kept_false = 0, rejected_true = 0, added = 0;
};

void AddSeed(const PoseGraph3& clean, const PoseGraph3& dirty, Row* row) {
  PoseGraph3 graph = dirty;
  const double start = ThreadSeconds();
  InitializeChordalFromTrusted(&graph);
  const GncSummary summary = OptimizeByGnc(&graph);
  row->seconds.push_back(ThreadSeconds() - start);
  row->errors.push_back(TrajectoryError(clean, graph));
  for (std::size_t k = 0; k < graph.edges.size(); ++k) {
    const bool added = k >= clean.edges.size(), kept = summary.weights[k] >= 0.5;
    row->added += added;
    row->kept_false += added && kept;
    row->rejected_true += !added && !kept;
  }
}

double Largest(const std::vector<double>& values) {
  return *std::max_element(values.begin(), values.end());
}

void PrintRow(const char* kind, double share, double clean_error, const Row& row) {
  const double worst = Largest(row.errors);
  std::printf("| %s, %.0f %% | %.3f | %.2f | %zu of %zu | %zu | %.1f |\n", kind, 100.0 * share,
              worst, (clean_error + worst) / clean_error, row.kept_false, row.added,
              row.rejected_true, Largest(row.seconds));
  std::fflush(stdout);
}

// All rows, or the one of that kind and share.
void PrintTable(const G2oGraph& file, const std::string& path, const std::string& only_kind = "",
                double only_share = 0.0) {
  const PoseGraph3 clean = Solved(MakePoseGraph<3>(file, path));
  const double clean_error = CleanError(clean);
  std::printf(
      "| false closures added | to the clean optimum m | error at most, of the clean | false kept "
      "| true rejected | CPU s |\n|---|---|---|---|---|---|\n");
  for (const double share : kShares) {
    for (const char* kind : kKinds) {
      if (!only_kind.empty() && (kind != only_kind || share != only_share)) continue;
      Row row;
      for (int seed = 0; seed < kSeeds; ++seed) {
        G2oGraph dirty = file;
        AddFalseClosures(ParseFalseClosureKind(kind), share, seed, &dirty);
        AddSeed(clean, MakePoseGraph<3>(dirty, path), &row);
      }
      PrintRow(kind, share, clean_error, row);
    }
  }
}

int Run(int argc, char** argv) {
  G2oGraph graph = ReadG2o(argv[1]);
  if (argc == 2) {
    PrintTable(graph, argv[1]);
  } else if (argc == 4) {
    PrintTable(graph, argv[1], argv[2], std::strtod(argv[3], nullptr));
  } else {
    AddFalseClosures(ParseFalseClosureKind(argv[2]), std::strtod(argv[3], nullptr),
                     std::strtoull(argv[4], nullptr, 10), &graph);
    WriteG2o(argv[5], graph);
  }
  return 0;
}

}  // namespace
}  // namespace planegraph

int main(int argc, char** argv) {
  if (argc != 2 && argc != 4 && argc != 6) {
    std::fprintf(stderr, "usage: closures_table GRAPH.g2o [KIND SHARE [SEED OUT.g2o]]\n");
    return 1;
  }
  return planegraph::ReportErrors([&] { return planegraph::Run(argc, argv); });
}
