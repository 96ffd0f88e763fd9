// A simulated sphere, as the well-known graph sphere2500 with a truth, and false loop closures
// added.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "planegraph/geometry/alignment.h"
#include "planegraph/pose_graph/robust_optimization.h"
#include "pose_graph/graphs.h"

namespace planegraph {
namespace {

constexpr int kRings = 14, kPerRing = 20, kPoses = kRings * kPerRing;
constexpr double kRadius = 10.0, kSigmaTranslation = 0.05, kSigmaRotation = 0.01;

// On a spiral from pole to pole; the poses are the truth.
PoseGraph3 Sphere(std::mt19937_64* rng) {
  PoseGraph3 graph;
  for (int i = 0; i < kPoses; ++i) {
    const double longitude = 2.0 * std::numbers::pi * i / kPerRing;
    const double latitude = std::numbers::pi * ((i + 0.5) / kPoses - 0.5);
    GraphPose<3> pose;
    pose.rotation = (Eigen::AngleAxisd(longitude, Eigen::Vector3d::UnitZ()) *
                     Eigen::AngleAxisd(latitude, Eigen::Vector3d::UnitY()))
                        .toRotationMatrix();
    pose.translation = pose.rotation * Eigen::Vector3d(kRadius, 0.0, 0.0);
    graph.poses.push_back(pose);
  }
  graph.fixed.assign(kPoses, false);
  const PoseInformation<3> information = IsotropicInformation<3>(
      {1.0 / std::pow(kSigmaTranslation, 2), 0.5 / std::pow(kSigmaRotation, 2)});
  for (int i = 0; i < kPoses; ++i) {
    for (const int to : {i + 1, i + kPerRing}) {
      if (to >= kPoses) continue;
      const auto noise = RandomStep<3>(rng, kSigmaTranslation, kSigmaRotation);
      graph.edges.push_back({i, to, Retract<3>(Relative(graph.poses[i], graph.poses[to]), noise),
                             information, to != i + 1});
    }
  }
  return graph;
}

// One place taken for another: what a true closure measured, between poses drawn at random.
void AddFalseClosures(double share, std::mt19937_64* rng, PoseGraph3* graph) {
  std::vector<GraphEdge<3>> closures;
  for (const GraphEdge<3>& edge : graph->edges) {
    if (edge.robust) closures.push_back(edge);
  }
  const auto count = static_cast<std::size_t>(share * static_cast<double>(closures.size()));
  for (std::size_t added = 0; added < count;) {
    GraphEdge<3> edge = closures[(*rng)() % closures.size()];
    edge.from = static_cast<int>((*rng)() % kPoses);
    edge.to = static_cast<int>((*rng)() % kPoses);
    const int apart = std::abs(edge.to - edge.from);
    if (apart < 2 || std::abs(apart - kPerRing) < 2) continue;  // these could be nearly true
    graph->edges.push_back(edge);
    ++added;
  }
}

// `runs` stretches of `length` poses, each taken for another stretch by one and the same motion.
void AddFalseRuns(int runs, int length, std::mt19937_64* rng, PoseGraph3* graph) {
  std::vector<GraphEdge<3>> closures;
  for (const GraphEdge<3>& edge : graph->edges) {
    if (edge.robust) closures.push_back(edge);
  }
  for (int run = 0; run < runs;) {
    GraphEdge<3> edge = closures[(*rng)() % closures.size()];
    const int from = static_cast<int>((*rng)() % (kPoses - length));
    const int to = static_cast<int>((*rng)() % (kPoses - length));
    const int apart = std::abs(to - from);
    if (apart <= length || std::abs(apart - kPerRing) < 2) continue;
    for (int k = 0; k < length; ++k) {
      edge.from = from + k, edge.to = to + k;
      graph->edges.push_back(edge);
    }
    ++run;
  }
}

// Root mean square of the positions' errors after the best rigid alignment.
double TrajectoryError(const PoseGraph3& graph, const PoseGraph3& truth) {
  std::vector<Eigen::Vector3d> found, wanted;
  for (int i = 0; i < kPoses; ++i) {
    found.push_back(graph.poses[i].translation);
    wanted.push_back(truth.poses[i].translation);
  }
  const Sim3 motion = AlignPoints(found, wanted, false).target_from_source;
  double sum = 0.0;
  for (int i = 0; i < kPoses; ++i) sum += (motion * found[i] - wanted[i]).squaredNorm();
  return std::sqrt(sum / kPoses);
}

class FalseClosures : public testing::TestWithParam<double> {};

TEST_P(FalseClosures, LeaveTheTrajectoryAsGoodAsWithoutThem) {
  for (std::uint64_t seed = 0; seed < 3; ++seed) {
    SCOPED_TRACE(seed);
    std::mt19937_64 rng(seed);
    const PoseGraph3 truth = Sphere(&rng);
    PoseGraph3 clean = truth, dirty = truth;
    InitializeChordal(&clean);
    ASSERT_TRUE(OptimizePoseGraph(&clean).converged);
    AddFalseClosures(GetParam(), &rng, &dirty);
    InitializeChordalFromTrusted(&dirty);
    const GncSummary summary = OptimizeByGnc(&dirty);
    EXPECT_TRUE(summary.last.converged);
    for (std::size_t k = truth.edges.size(); k < dirty.edges.size(); ++k) {
      EXPECT_EQ(summary.weights[k], 0.0) << k;
    }
    EXPECT_LE(TrajectoryError(dirty, truth), 1.5 * TrajectoryError(clean, truth));
  }
}

INSTANTIATE_TEST_SUITE_P(Shares, FalseClosures, testing::Values(0.1, 0.5, 1.0));

// Runs of false closures that support each other, in a graph that claims five times its noise: the
// odometry is then loose enough to give way to a run, unless the noise is measured.
TEST(OptimizeByGnc, MeasuresTheNoiseThatIsFarBelowItsClaim) {
  for (std::uint64_t seed = 0; seed < 3; ++seed) {
    SCOPED_TRACE(seed);
    std::mt19937_64 rng(seed);
    const PoseGraph3 truth = Sphere(&rng);
    PoseGraph3 clean = truth;
    for (GraphEdge<3>& edge : clean.edges) edge.information /= 25.0;
    PoseGraph3 dirty = clean;
    InitializeChordal(&clean);
    OptimizePoseGraph(&clean);
    AddFalseRuns(20, 8, &rng, &dirty);
    InitializeChordalFromTrusted(&dirty);
    const GncSummary summary = OptimizeByGnc(&dirty);
    // 6.19 claimed sigmas would be one in a million; they are five times too large.
    EXPECT_NEAR(summary.scale, 6.19 / 5.0, 0.15);
    std::size_t rejected = 0;
    for (std::size_t k = 0; k < dirty.edges.size(); ++k) {
      const bool is_false = k >= truth.edges.size();
      EXPECT_TRUE(!is_false || summary.weights[k] == 0.0) << k;
      rejected += !is_false && summary.weights[k] < 0.5;
    }
    EXPECT_EQ(rejected, 0u);
    EXPECT_LE(TrajectoryError(dirty, truth), 1.5 * TrajectoryError(clean, truth));
  }
}

// The weights are those of the robust cost at the poses that were found.
TEST(OptimizeByGnc, EndsWhereWeightsAndPosesAgree) {
  std::mt19937_64 rng(7);
  PoseGraph3 graph = Sphere(&rng);
  AddFalseClosures(0.5, &rng, &graph);
  InitializeChordalFromTrusted(&graph);
  const GncSummary summary = OptimizeByGnc(&graph);
  const double limit = 16.812;  // 99 % quantile of chi-square, six degrees of freedom
  for (std::size_t k = 0; k < graph.edges.size(); ++k) {
    const bool inlier = !graph.edges[k].robust || EdgeChi2(graph, graph.edges[k]) <= limit;
    EXPECT_EQ(summary.weights[k], inlier ? 1.0 : 0.0) << k;
  }
}

}  // namespace
}  // namespace planegraph
