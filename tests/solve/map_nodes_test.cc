// Drone maps as nodes of the graph.
#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <random>

#include "planegraph/geometry/rotation.h"
#include "planegraph/graph/graph.h"
#include "planegraph/solve/association.h"
#include "planegraph/solve/covariance.h"
#include "planegraph/solve/marginal_graph.h"
#include "planegraph/solve/solver.h"

namespace planegraph {
namespace {

using Eigen::Vector3d;

Vector3d RandomVector(std::mt19937_64* rng, double size) {
  std::uniform_real_distribution<double> uniform(-size, size);
  const double x = uniform(*rng), y = uniform(*rng), z = uniform(*rng);
  return {x, y, z};
}

// Two scans and a map that see the same planes; `sigma` metres of noise in the map's offsets.
Graph MakeWorld(std::uint64_t seed, double sigma, const Sim3& world_from_map) {
  std::mt19937_64 rng(seed);
  std::normal_distribution<double> normal;
  Graph graph;
  graph.poses.push_back({"0", Rigid3(), true});
  graph.poses.push_back({"1", {ExpSO3({0.1, -0.2, 0.7}), {4, 2, 0.3}}, false});
  graph.maps.push_back({"map", world_from_map, false});
  for (int k = 0; k < 24; ++k) {
    const Vector3d n = RandomVector(&rng, 1.0).normalized(), at = RandomVector(&rng, 12.0);
    PlaneLandmark plane{at, n, 0.0, {}, -1};
    Eigen::Matrix3d axes;
    axes << n, TangentBasis(n);
    for (int node = 0; node < 3; ++node) {
      PlaneObservation seen;
      if (node == 2)
        seen.map = 0;
      else
        seen.pose = node;
      const Sim3 node_from_world = WorldFromObservation(graph, seen).Inverse();
      const double noise = node == 2 ? sigma * normal(rng) : 0.0;
      seen.centroid =
          node_from_world * (at + noise * n + axes.rightCols<2>() * Eigen::Vector2d(0.2, -0.1));
      seen.axes = node_from_world.rotation.toRotationMatrix() * axes;
      seen.tilt_weight_1 = seen.tilt_weight_2 = node == 2 ? 1e-3 : 1e3;
      seen.offset_weight = node == 2 ? 1.0 / std::max(sigma, 0.01) : 1e4;
      seen.point_count = 100;
      plane.observations.push_back(seen);
    }
    graph.planes.push_back(plane);
  }
  return graph;
}

const Sim3 kTruth(8.5, ExpSO3({1.0, -0.4, 2.0}), {10, -20, 5});

void Disturb(Graph* graph) {
  Sim3& map = graph->maps[0].world_from_map;
  map.scale *= 1.05;
  map.rotation = ExpSO3({0.03, 0.02, -0.04}) * map.rotation;
  map.translation += Vector3d(0.3, -0.2, 0.4);
  graph->poses[1].world_from_node.translation += Vector3d(0.1, 0.1, -0.1);
}

// Where the heap puts poses and maps must not decide in which order they are eliminated.
TEST(MapNodes, TheHeapChangesNoBit) {
  std::vector<std::vector<double>> ballast;
  std::vector<Sim3> found;
  for (int k = 0; k < 12; ++k) {
    for (int i = 0; i < 40; ++i) ballast.emplace_back(1 + (7 * i + 3 * k) % 40);
    for (std::size_t i = k % 3; i < ballast.size(); i += 3) ballast[i] = {};
    Graph graph = MakeWorld(1, 0.02, kTruth);
    Disturb(&graph);
    ASSERT_TRUE(Solve(&graph).usable);
    found.push_back(graph.maps[0].world_from_map);
  }
  for (const Sim3& other : found) {
    EXPECT_EQ(other.scale, found[0].scale);
    EXPECT_EQ(other.translation, found[0].translation);
    EXPECT_EQ(other.rotation.coeffs(), found[0].rotation.coeffs());
  }
}

class EveryPlaneFactor : public testing::TestWithParam<const char*> {};

TEST_P(EveryPlaneFactor, FindsScaleAndPlaceOfAMap) {
  Graph graph = MakeWorld(1, 0.0, kTruth);
  const Rigid3 pose = graph.poses[1].world_from_node;
  Disturb(&graph);
  SolveOptions options;
  options.plane_factor = GetParam();
  ASSERT_TRUE(Solve(&graph, options).usable);
  const Sim3& found = graph.maps[0].world_from_map;
  EXPECT_NEAR(found.scale / kTruth.scale, 1.0, 1e-7);
  EXPECT_LT(AngleBetween(found.rotation, kTruth.rotation), 1e-7);
  EXPECT_LT((found.translation - kTruth.translation).norm(), 1e-6);
  EXPECT_LT((graph.poses[1].world_from_node.translation - pose.translation).norm(), 1e-6);
}
INSTANTIATE_TEST_SUITE_P(PlaneFactors, EveryPlaneFactor,
                         testing::Values("moments", "pose_pose", "normal_offset", "closest_point",
                                         "unit_quaternion", "eliminated"));

TEST(MapNodes, TheSigmaOfTheScaleIsHonest) {
  double sum = 0.0;
  constexpr int kTrials = 200;
  for (int trial = 0; trial < kTrials; ++trial) {
    Graph graph = MakeWorld(100 + trial, 0.05, kTruth);
    Solve(&graph);
    const double variance = GraphCovariance(graph).Map(0)(6, 6);
    sum += std::pow(std::log(graph.maps[0].world_from_map.scale / kTruth.scale), 2) / variance;
  }
  // Mean of chi-square with one degree of freedom over 200 trials: 1 +- 3 * sqrt(2 / 200).
  EXPECT_NEAR(sum / kTrials, 1.0, 0.3);
}

TEST(MapNodes, CamerasAlonePlaceAMap) {
  std::mt19937_64 rng(4);
  Graph graph;
  graph.maps.push_back({"map", kTruth, false});
  for (int k = 0; k < 10; ++k) {
    MapFactor factor;
    factor.maps = {0};
    factor.point = RandomVector(&rng, 5.0);
    factor.position = kTruth * factor.point;
    factor.information.setIdentity();
    graph.map_factors.push_back(factor);
  }
  graph.maps[0].world_from_map = Sim3(7.0, Eigen::Quaterniond(ExpSO3({0.9, -0.3, 1.8})), {0, 0, 0});
  ASSERT_TRUE(Solve(&graph).usable);
  EXPECT_NEAR(graph.maps[0].world_from_map.scale, kTruth.scale, 1e-6);
  EXPECT_LT((graph.maps[0].world_from_map.translation - kTruth.translation).norm(), 1e-5);
}

TEST(MapNodes, AMapAddsNothingToTheEdgesBetweenScans) {
  Graph with = MakeWorld(3, 0.0, kTruth), without = with;
  without.maps.clear();
  for (auto& plane : without.planes) plane.observations.pop_back();
  const auto a = MarginalEdges(with, {{0, 1}}), b = MarginalEdges(without, {{0, 1}});
  EXPECT_LT((a[0].information - b[0].information).norm(), 1e-6 * b[0].information.norm());
}

PlaneSet Patches(const Vector3d& mean, const Vector3d& normal, CloudKind kind) {
  PlaneSet set;
  set.kind = kind;
  Patch patch;
  const auto basis = TangentBasis(normal);
  for (int i = -2; i <= 2; ++i) {
    for (int j = -2; j <= 2; ++j) {
      patch.moments.Add(mean + 0.1 * i * basis.col(0) + 0.1 * j * basis.col(1));
    }
  }
  patch.normal = normal;
  patch.size = 0.4;
  patch.sigma = 0.01;
  set.patches.push_back(patch);
  return set;
}

TEST(AssociateWithMaps, AMapIsOneMoreObservationAndNoSeed) {
  const PlaneSet scan = Patches({2, 0, 0}, -Vector3d::UnitX(), CloudKind::kLaser);
  const PlaneSet map = Patches({0.21, 0, 0}, -Vector3d::UnitX(), CloudKind::kVision);
  const std::vector<PlacedMap> placed{
      {&map, Sim3(10.0, Eigen::Quaterniond::Identity(), {0, 0, 0})}};
  AssociationOptions options;
  const auto landmarks = AssociatePatches({&scan}, {Rigid3()}, options, placed);
  ASSERT_EQ(landmarks.size(), 1u);
  ASSERT_EQ(landmarks[0].observations.size(), 2u);
  EXPECT_EQ(landmarks[0].observations[0].map, -1);
  EXPECT_EQ(landmarks[0].observations[1].map, 0);
  EXPECT_LT(landmarks[0].observations[1].offset_weight, landmarks[0].observations[0].offset_weight);
  EXPECT_TRUE(AssociatePatches({}, {}, options, placed).empty());
}

// Principal axes have no side of their own; what seeks poses from nothing needs one.
TEST(Associate, ObservationsFaceAsTheirLandmark) {
  const Rigid3 turned(ExpSO3({0.3, -0.2, 2.5}), {1.0, 2.0, -0.5});
  for (int axis = 0; axis < 3; ++axis) {
    for (double side : {-1.0, 1.0}) {
      const Vector3d normal = side * Vector3d::Unit(axis), centre = -3.0 * normal;
      const PlaneSet here = Patches(centre, normal, CloudKind::kLaser);
      const Rigid3 scan_from_world = turned.Inverse();
      const PlaneSet there =
          Patches(scan_from_world * centre, scan_from_world.rotation * normal, CloudKind::kLaser);
      const auto landmarks = AssociatePatches({&here, &there}, {Rigid3(), turned});
      ASSERT_EQ(landmarks.size(), 1u);
      EXPECT_GT(landmarks[0].normal.dot(normal), 0.99);
      ASSERT_EQ(landmarks[0].observations.size(), 2u);
      EXPECT_GT(landmarks[0].observations[0].axes.col(0).dot(normal), 0.99);
      EXPECT_GT((turned.rotation * landmarks[0].observations[1].axes.col(0)).dot(normal), 0.99);
      for (const PlaneObservation& seen : landmarks[0].observations) {
        EXPECT_NEAR(seen.axes.determinant(), 1.0, 1e-9);
      }
    }
  }
}

TEST(AssociateWithMaps, ARoofsUndersideIsNotItsTop) {
  const PlaneSet underside = Patches({0, 0, 5.0}, -Vector3d::UnitZ(), CloudKind::kLaser);
  const PlaneSet top = Patches({0, 0, 5.05}, Vector3d::UnitZ(), CloudKind::kVision);
  const std::vector<PlacedMap> placed{{&top, Sim3()}};
  EXPECT_TRUE(AssociatePatches({&underside}, {Rigid3()}, {}, placed).empty());
}

}  // namespace
}  // namespace planegraph
