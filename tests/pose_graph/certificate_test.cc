#include "planegraph/pose_graph/certificate.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <map>

#include "planegraph/pose_graph/g2o_conversion.h"
#include "pose_graph/graphs.h"

namespace planegraph {
namespace {

template <int Dim>
void ExpectGlobalFromChordalStart(std::uint64_t seed) {
  PoseGraph<Dim> graph = NoisyGraph<Dim>(40, 0.1, 0.05, seed);
  InitializeChordal(&graph);
  const CertifiedSummary summary = OptimizeCertified(&graph);
  EXPECT_TRUE(summary.certificate.certified);
  EXPECT_NEAR(summary.certificate.objective, 2.0 * GraphCost(graph), 1e-9 * GraphCost(graph));
  // The bound has to hold for the best of minima from many starts.
  for (std::uint64_t start = 0; start < 10; ++start) {
    PoseGraph<Dim> other = graph;
    std::mt19937_64 rng(start);
    for (auto& pose : other.poses) pose = RandomPose<Dim>(&rng);
    OptimizePoseGraph(&other);
    EXPECT_GE(2.0 * GraphCost(other),
              summary.certificate.objective - summary.certificate.suboptimality_bound);
  }
}

TEST(Certificate, HoldsForTheBestOfManyMinima) {
  ExpectGlobalFromChordalStart<2>(1);
  ExpectGlobalFromChordalStart<3>(2);
}

TEST(Certificate, RefusesALocalMinimumAndTheStaircaseLeavesIt) {
  PoseGraph2 ring = WoundRing(20);
  ASSERT_TRUE(OptimizePoseGraph(&ring).converged);
  // 20 edges of |R(18 deg) - 1|^2 = 4 (1 - cos 18 deg).
  const double wound = 20.0 * 4.0 * (1.0 - std::cos(std::numbers::pi / 10.0));
  const Certificate local = Certify(ring);
  EXPECT_FALSE(local.certified);
  EXPECT_NEAR(local.objective, wound, 1e-9);
  EXPECT_GE(local.suboptimality_bound, wound * (1.0 - 1e-9));  // the minimum is zero
  const CertifiedSummary summary = OptimizeCertified(&ring);
  EXPECT_TRUE(summary.certificate.certified);
  EXPECT_EQ(summary.escapes, 1);
  EXPECT_LT(summary.certificate.objective, 1e-9);
}

// A minimum that a loose solve has left a little beside: the proof's own Newton steps get it there.
TEST(Certificate, ALooseMinimumIsMadeExactEnoughForTheProof) {
  PoseGraph3 graph = NoisyGraph<3>(40, 0.1, 0.05, 5);
  InitializeChordal(&graph);
  PoseGraphOptions loose;
  loose.tolerance = 0.1;
  OptimizePoseGraph(&graph, loose);
  const double before = 2.0 * GraphCost(graph);
  ASSERT_FALSE(Certify(graph).certified);
  const CertifiedSummary summary = CertifyMinimum(&graph);
  EXPECT_TRUE(summary.certificate.certified);
  EXPECT_EQ(summary.escapes, 0);
  EXPECT_LT(summary.certificate.objective, before);
  EXPECT_NEAR(summary.certificate.objective, 2.0 * GraphCost(graph), 1e-9 * before);
}

TEST(Certificate, ConsistentEdgesAreCertified) {
  PoseGraph3 graph = NoisyGraph<3>(20, 0.0, 0.0, 3);
  EXPECT_TRUE(OptimizeCertified(&graph).certificate.certified);
}

// Small is not nothing: residuals of a thousandth of a sigma have to be certified like any others.
TEST(Certificate, ASmallObjectiveNeedsAProofToo) {
  PoseGraph2 ring = WoundRing(20);
  for (GraphEdge<2>& edge : ring.edges) edge.information *= 1e-8;
  const Certificate local = Certify(ring);
  EXPECT_GT(local.objective, 1e-9);
  EXPECT_FALSE(local.certified);
}

TEST(Certificate, NeedsIsotropicWeightsAndAFreeGauge) {
  PoseGraph3 graph = NoisyGraph<3>(10, 0.1, 0.1, 4);
  graph.fixed[2] = graph.fixed[3] = true;
  EXPECT_THROW(Certify(graph), std::invalid_argument);
  graph.fixed[3] = false;
  graph.edges[0].information(0, 1) = graph.edges[0].information(1, 0) = 0.5;
  EXPECT_THROW(Certify(graph), std::invalid_argument);
}

// Published optima (SE-Sync, refined): see the data's page.
TEST(Certificate, ReachesPublishedOptimaFromBothStarts) {
  const std::map<std::string, double> optima = {{"smallGrid3D", 1025.39802},
                                                {"parking-garage", 1.2625244}};
  for (const auto& [name, optimum] : optima) {
    const std::string path =
        std::string(PLANEGRAPH_SHARED_DATA) + "/posegraph/se_sync/" + name + ".g2o";
    if (!std::filesystem::exists(path)) GTEST_SKIP() << path << " is not there";
    G2oConversionOptions options;
    options.information = InformationUse::kIsotropic;
    const PoseGraph3 file = MakePoseGraph<3>(ReadG2o(path), path, options);
    for (const bool chordal : {true, false}) {
      PoseGraph3 graph = file;
      if (chordal) InitializeChordal(&graph);
      const CertifiedSummary summary = OptimizeCertified(&graph);
      EXPECT_TRUE(summary.certificate.certified) << name << chordal;
      EXPECT_LT(summary.certificate.objective, optimum * (1.0 + 1e-6)) << name << chordal;
    }
  }
}

}  // namespace
}  // namespace planegraph
