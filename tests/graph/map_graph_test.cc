// Drone maps in the graph: steps, checks, frames.
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <stdexcept>

#include "planegraph/geometry/rotation.h"
#include "planegraph/graph/factor_sampling.h"
#include "planegraph/graph/graph.h"
#include "planegraph/graph/manifolds.h"

namespace planegraph {
namespace {

TEST(Sim3Manifold, TangentIsTheDecoupledLeftPerturbation) {
  const Sim3 map(8.5, ExpSO3({0.3, -0.2, 1.0}), {1, 2, 3});
  const auto block = FactorSampler::Block(map);
  const double delta[7] = {0.1, 0.2, 0.3, 0.0, 0.0, 0.5, 0.2};
  double moved[8];
  Sim3Manifold().Plus(block.data(), delta, moved);
  const Sim3 result = MapFromBlock(moved);
  EXPECT_LT((result.translation - Eigen::Vector3d(1.1, 2.2, 3.3)).norm(), 1e-14);
  EXPECT_LT(AngleBetween(result.rotation, ExpSO3({0, 0, 0.5}) * map.rotation), 1e-7);
  EXPECT_NEAR(result.scale, 8.5 * std::exp(0.2), 1e-12);
}

TEST(Sim3Manifold, BlocksRoundTrip) {
  std::mt19937_64 rng(5);
  for (int trial = 0; trial < 100; ++trial) {
    const Sim3 map = FactorSampler(&rng).Map();
    double block[8];
    MapToBlock(map, block);
    const Sim3 back = MapFromBlock(block);
    EXPECT_NEAR(back.scale / map.scale, 1.0, 1e-12);
    EXPECT_EQ(back.translation, map.translation);
    EXPECT_LT(AngleBetween(back.rotation, map.rotation), 1e-7);
  }
}

Graph OnePlane() {
  Graph graph;
  graph.poses = {{"scan", Rigid3(ExpSO3({0.1, 0.2, 0.3}), {1, 2, 3})}};
  graph.maps = {{"a", Sim3(2.0, ExpSO3({0, 0, 1.0}), {4, 5, 6})},
                {"b", Sim3(3.0, ExpSO3({0, 1.0, 0}), {7, 8, 9})}};
  PlaneLandmark plane;
  plane.observations.resize(3);
  plane.observations[1].map = 0;
  plane.observations[2].map = 1;
  graph.planes = {plane};
  MapFactor factor;
  factor.maps = {1};
  graph.map_factors = {factor};
  return graph;
}

TEST(WorldFromObservation, IsThatOfItsNode) {
  const Graph graph = OnePlane();
  const auto& seen = graph.planes[0].observations;
  const Eigen::Vector3d p(0.5, -1.0, 2.0);
  EXPECT_LT((WorldFromObservation(graph, seen[0]) * p - graph.poses[0].world_from_node * p).norm(),
            1e-12);
  EXPECT_EQ(WorldFromObservation(graph, seen[0]).scale, 1.0);
  for (int m = 0; m < 2; ++m) {
    const Sim3 found = WorldFromObservation(graph, seen[m + 1]);
    EXPECT_EQ(found.scale, graph.maps[m].world_from_map.scale);
    EXPECT_EQ(found.translation, graph.maps[m].world_from_map.translation);
  }
}

// Each change must be refused.
void ExpectRefused(const std::function<void(Graph*)>& change) {
  Graph graph = OnePlane();
  ASSERT_NO_THROW(CheckGraph(graph));
  change(&graph);
  EXPECT_THROW(CheckGraph(graph), std::invalid_argument);
}

TEST(CheckGraph, RefusesMapsThatAreNoSimilarities) {
  for (const double scale : {0.0, -1.0, double(NAN), double(INFINITY)}) {
    ExpectRefused([&](Graph* g) { g->maps[0].world_from_map.scale = scale; });
  }
  ExpectRefused([](Graph* g) { g->maps[0].world_from_map.translation.x() = NAN; });
  ExpectRefused([](Graph* g) { g->maps[1].world_from_map.rotation.coeffs() *= 1.1; });
  ExpectRefused([](Graph* g) { g->maps[1].world_from_map.rotation.coeffs().setZero(); });
}

TEST(CheckGraph, RefusesObservationsAndFactorsWithoutTheirMap) {
  ExpectRefused([](Graph* g) { g->planes[0].observations[1].map = 2; });
  ExpectRefused([](Graph* g) { g->maps.clear(); });
  ExpectRefused([](Graph* g) { g->map_factors[0].maps = {}; });
  ExpectRefused([](Graph* g) { g->map_factors[0].maps = {2}; });
  ExpectRefused([](Graph* g) { g->map_factors[0].maps = {-1}; });
  ExpectRefused([](Graph* g) { g->map_factors[0].maps = {0, 0}; });
  ExpectRefused([](Graph* g) { g->map_factors[0].maps = {0, 1, 0}; });
  ExpectRefused([](Graph* g) { g->map_factors[0].point.x() = NAN; });
  ExpectRefused([](Graph* g) { g->map_factors[0].position.z() = INFINITY; });
  ExpectRefused([](Graph* g) { g->map_factors[0].information(2, 1) = NAN; });
}

TEST(MakePlaneLandmark, StartsFromAMapAsItIsPlaced) {
  Graph graph = OnePlane();
  PlaneObservation seen;
  seen.map = 0;
  seen.centroid = {1, 0, 0};
  seen.axes = ExpSO3({0.4, 0.5, 0.6}).toRotationMatrix();
  seen.point_count = 10;
  const PlaneLandmark plane = MakePlaneLandmark(graph, {seen});
  const Sim3& map = graph.maps[0].world_from_map;
  EXPECT_LT((plane.anchor - map * seen.centroid).norm(), 1e-12);
  EXPECT_LT((plane.normal - map.rotation * seen.axes.col(0)).norm(), 1e-12);
  EXPECT_NEAR(plane.offset, 0.0, 1e-12);
}

}  // namespace
}  // namespace planegraph
