// Drone maps cut into tiles: where the tiles lie, how they blend, and what they do to a graph.
#include "planegraph/pipeline/map_tiling.h"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <random>
#include <set>

#include "pipeline/tiled_graph.h"
#include "planegraph/base/disjoint_sets.h"
#include "planegraph/base/error.h"
#include "planegraph/geometry/rotation.h"
#include "planegraph/graph/manifolds.h"
#include "planegraph/solve/covariance.h"
#include "planegraph/solve/solver.h"

namespace planegraph {
namespace {

using Eigen::Vector3d;

// Surfaces of a map of 80 m by 50 m, world.
std::vector<Vector3d> Places(std::uint64_t seed) {
  std::mt19937_64 rng(seed);
  std::uniform_real_distribution<double> x(-40.0, 40.0), y(-25.0, 25.0), z(0.0, 8.0);
  std::vector<Vector3d> places;
  for (int k = 0; k < 400; ++k) {
    const double a = x(rng), b = y(rng), c = z(rng);
    places.emplace_back(a, b, c);
  }
  return places;
}

PlaneSet Surfaces(const std::vector<Vector3d>& world, const Sim3& world_from_metric) {
  PlaneSet set;
  for (const Vector3d& place : world) {
    set.patches.emplace_back();
    set.patches.back().moments.mean = world_from_metric.Inverse() * place;
  }
  return set;
}

MapTiling Tiling(double size) {
  MapTiling tiling;
  tiling.size = size;
  return tiling;
}

MapGrid Grid(double size, const std::vector<Vector3d>& world, const Sim3& frame = {}) {
  return MapGrid(Tiling(size), Surfaces(world, frame), frame, "cloud.ply");
}

const Sim3 kFrame(0.13, ExpSO3({0.4, -1.0, 2.0}), {100.0, -300.0, 20.0});

TEST(MapGrid, EverySurfaceIsInTheCellOfItsTile) {
  const auto places = Places(1);
  const MapGrid grid = Grid(20.0, places);
  EXPECT_EQ(grid.count(), 12u) << "4 by 3";
  for (const Vector3d& place : places) {
    const Vector3d off = place - grid.Middle(grid.TileAt(place));
    EXPECT_LE(off.head<2>().cwiseAbs().maxCoeff(), 10.0 + 1e-9);
  }
}

TEST(MapGrid, TheFrameOfTheMapDoesNotMatter) {
  const auto places = Places(2);
  const MapGrid grid = Grid(20.0, places), other = Grid(20.0, places, kFrame);
  ASSERT_EQ(grid.count(), other.count());
  const Sim3 frame_from_world = kFrame.Inverse();
  for (const Vector3d& place : Places(3)) {
    EXPECT_EQ(grid.TileAt(place), other.TileAt(frame_from_world * place));
  }
  ASSERT_EQ(grid.ties().size(), other.ties().size());
  for (std::size_t k = 0; k < grid.ties().size(); ++k) {
    EXPECT_NEAR(grid.ties()[k].distance, other.ties()[k].distance, 1e-6);
    EXPECT_LT((grid.ties()[k].border - kFrame * other.ties()[k].border).norm(), 1e-6);
  }
}

TEST(MapGrid, TheOrderOfTheSurfacesDoesNotMatter) {
  auto places = Places(4);
  const MapGrid grid = Grid(20.0, places);
  std::reverse(places.begin(), places.end());
  const MapGrid other = Grid(20.0, places);
  for (const Vector3d& place : places) {
    const Vector3d off = grid.Middle(grid.TileAt(place)) - other.Middle(other.TileAt(place));
    EXPECT_LT(off.norm(), 1e-9);
  }
}

TEST(MapGrid, AllTilesHangTogetherAcrossGaps) {
  auto places = Places(5);
  for (const Vector3d& place : Places(6)) places.push_back(place + Vector3d(300.0, 120.0, 0.0));
  const MapGrid grid = Grid(10.0, places);
  DisjointSets parts(grid.count());
  for (const MapGrid::Tie& tie : grid.ties()) parts.Join(tie.target, tie.source);
  for (std::size_t t = 0; t < grid.count(); ++t) EXPECT_EQ(parts.Find(t), parts.Find(0));
}

TEST(MapGrid, WeightsAddUpToOneAndChangeWithoutJumps) {
  const MapGrid grid = Grid(20.0, Places(7));
  std::vector<double> before;
  for (double x = -70.0; x < 70.0; x += 0.05) {
    std::vector<double> weights(grid.count(), 0.0);
    double sum = 0.0;
    for (const auto& [tile, weight] : grid.At({x, 0.3 * x, 1.0})) {
      weights[tile] += weight;
      sum += weight;
    }
    EXPECT_NEAR(sum, 1.0, 1e-12);
    for (std::size_t t = 0; !before.empty() && t < weights.size(); ++t) {
      // A way of 0.0522 m over cells of 20 m; the weights change by at most its parts over 20 m.
      EXPECT_LT(std::abs(weights[t] - before[t]), 2.0 * 1.3 * 0.05 / 20.0);
    }
    before = weights;
  }
}

TEST(MapGrid, ATilesMiddleIsItsAlone) {
  const MapGrid grid = Grid(20.0, Places(8));
  for (std::size_t t = 0; t < grid.count(); ++t) {
    double own = 0.0;
    for (const auto& [tile, weight] : grid.At(grid.Middle(static_cast<int>(t)))) {
      if (tile == static_cast<int>(t)) own = weight;
    }
    EXPECT_NEAR(own, 1.0, 1e-9);
  }
}

TEST(MapGrid, RefusesMoreTilesThanItCanSolve) {
  std::vector<Vector3d> places;
  for (int k = 0; k < 1100; ++k) places.emplace_back(3.0 * k, 0.0, 0.0);
  EXPECT_THROW(Grid(1.0, places), InputError);
  EXPECT_NO_THROW(Grid(100.0, places));
}

BentMap Bent(const MapGrid& grid, std::uint64_t seed, double size) {
  std::mt19937_64 rng(seed);
  std::normal_distribution<double> normal(0.0, size);
  BentMap map{std::make_shared<MapGrid>(grid), {}};
  for (std::size_t t = 0; t < grid.count(); ++t) {
    Vector7d by;
    for (int k = 0; k < 7; ++k) by[k] = (k < 3 ? 1.0 : 0.01) * normal(rng);
    map.world_from_tile.push_back(
        {std::exp(by[6]), ExpSO3(by.segment<3>(3)), Vector3d(by.head<3>())});
  }
  return map;
}

TEST(BendingFit, TilesThatStandTogetherAreOneSimilarity) {
  const PlaneSet planes = Surfaces(Places(9), kFrame);
  const MapGrid grid(Tiling(20.0), planes, kFrame, "");
  const BendingFit fit = FitBentMap(
      {std::make_shared<MapGrid>(grid), std::vector<Sim3>(grid.count(), kFrame)}, planes);
  EXPECT_NEAR(fit.world_from_metric.scale, kFrame.scale, 1e-10);
  EXPECT_LT(AngleBetween(fit.world_from_metric.rotation, kFrame.rotation), 1e-7);
  EXPECT_LT(fit.largest, 1e-8);
}

TEST(BendingFit, ItsDerivativesAreThoseOfTheFit) {
  const PlaneSet planes = Surfaces(Places(10), {});
  const MapGrid grid(Tiling(30.0), planes, {}, "");
  BentMap map = Bent(grid, 1, 0.0);
  const BendingFit fit = FitBentMap(map, planes);
  const auto by_tiles = FitByTiles(map, fit, planes);
  Matrix7d sum = Matrix7d::Zero();
  for (const Matrix7d& block : by_tiles) sum += block;
  EXPECT_LT((sum - Matrix7d::Identity()).norm(), 1e-8) << "all together move the whole";
  const double step = 1e-5;
  map.world_from_tile[2].translation.z() += step;
  map.world_from_tile[2].scale *= std::exp(step);
  const Vector7d expected = step * (by_tiles[2].col(2) + by_tiles[2].col(6));
  const Sim3 moved = FitBentMap(map, planes).world_from_metric;
  EXPECT_LT((moved.translation - expected.head<3>()).norm(), 1e-3 * step);
  EXPECT_LT((LogSO3(moved.rotation) - expected.segment<3>(3)).norm(), 1e-3 * step);
  EXPECT_NEAR(std::log(moved.scale), expected[6], 1e-3 * step);
}

// ---- graphs ----

// A row of scans along x, each two of which share surfaces, and a map that joins them; all see
// planes of all directions. `bowl` lifts the
// map by bowl * (x^2 + y^2) with its slopes; `sigma`: noise of its heights, metres.
struct World {
  World(std::uint64_t seed, double bowl, double sigma) {
    std::mt19937_64 rng(seed);
    std::normal_distribution<double> normal;
    std::uniform_real_distribution<double> any(-1.0, 1.0);
    for (int i = 0; i < 6; ++i) {
      graph.poses.push_back(
          {std::to_string(i), {ExpSO3({0.0, 0.0, 0.3 * i}), {-30.0 + 12.0 * i, 2.0, 1.0}}, i == 0});
    }
    graph.maps.push_back({"map", Sim3(), false, 0});
    for (int k = 0; k < 240; ++k) {
      const int pose = k % 6;
      const double a = any(rng), b = any(rng), c = any(rng);
      const Vector3d at =
          graph.poses[pose].world_from_node.translation + Vector3d(9.0 * a, 9.0 * b, 2.0 * c);
      const Vector3d n = Vector3d::Unit(k / 6 % 3);
      const Vector3d up(0.0, 0.0, bowl * at.head<2>().squaredNorm());
      const Eigen::Quaterniond turn =
          ExpSO3(Vector3d(2.0 * bowl * at.y(), -2.0 * bowl * at.x(), 0));
      PlaneLandmark plane{at, n, 0.0, {}, -1};
      Add(pose, -1, at, n, 1e3, &plane);
      if (pose < 5 && k % 2 == 0) Add(pose + 1, -1, at, n, 1e3, &plane);
      Add(0, 0, at + up + sigma * normal(rng) * n, turn * n, 1.0 / std::max(0.01, sigma), &plane);
      places.push_back(at + up);
      graph.planes.push_back(plane);
    }
  }

  void Add(int pose, int map, const Vector3d& at, const Vector3d& n, double weight,
           PlaneLandmark* plane) const {
    PlaneObservation seen;
    seen.pose = pose, seen.map = map;
    const Sim3 node_from_world = WorldFromObservation(graph, seen).Inverse();
    Eigen::Matrix3d axes;
    axes << n, TangentBasis(n);
    seen.centroid = node_from_world * at;
    seen.axes = node_from_world.rotation.toRotationMatrix() * axes;
    seen.offset_weight = weight, seen.tilt_weight_1 = seen.tilt_weight_2 = map < 0 ? 1e3 : 1.0;
    seen.point_count = 100;
    plane->observations.push_back(seen);
  }

  // Solved with tiles of 20 m whose ties are `looser` than those that are the default.
  Graph Solved(double looser) const {
    Graph cut = graph;
    MapTiling tiling = Tiling(20.0);
    tiling.sigma_rotation *= looser, tiling.sigma_translation *= looser;
    tiling.sigma_scale *= looser;
    JointSolution solution;
    solution.bent_maps.resize(1);
    if (looser > 0.0) {
      const auto grid = std::make_shared<MapGrid>(tiling, Surfaces(places, {}), Sim3(), "");
      solution.bent_maps[0] = {grid, std::vector<Sim3>(grid->count())};
    }
    CutMaps(solution, &cut);
    EXPECT_TRUE(Solve(&cut).usable);
    return cut;
  }

  Graph graph;
  std::vector<Vector3d> places;
};

double LargestMove(const Graph& a, const Graph& b) {
  double largest = 0.0;
  for (std::size_t i = 0; i < a.poses.size(); ++i) {
    largest = std::max(
        largest,
        (a.poses[i].world_from_node.translation - b.poses[i].world_from_node.translation).norm());
  }
  return largest;
}

TEST(CutMaps, WithoutTilesTheGraphStaysAsItIs) {
  const World world(1, 0.0, 0.02);
  const Graph whole = world.Solved(0.0);
  EXPECT_EQ(whole.maps.size(), 1u);
  EXPECT_EQ(whole.map_factors.size(), 0u);
}

TEST(CutMaps, RigidTiesAreTheWholeMap) {
  for (const double bowl : {0.0, 2e-4}) {
    const World world(2, bowl, 0.02);
    const Graph whole = world.Solved(0.0), cut = world.Solved(1e-5);
    ASSERT_GT(cut.maps.size(), 3u);
    EXPECT_LT(LargestMove(whole, cut), 1e-6);
    for (const MapNode& tile : cut.maps) {
      EXPECT_LT(
          (tile.world_from_map * world.places[7] - whole.maps[0].world_from_map * world.places[7])
              .norm(),
          1e-5);
    }
    // Not as stiff: the covariance loses digits where informations differ by 1e12.
    const Matrix6d a = GraphCovariance(whole).Pose(5),
                   b = GraphCovariance(world.Solved(1e-3)).Pose(5);
    EXPECT_LT((a - b).norm(), 1e-2 * a.norm());
  }
}

TEST(CutMaps, ABowlMovesScansLessThanAWholeMapDoes) {
  double whole = 0.0, cut = 0.0;
  for (std::uint64_t seed = 10; seed < 20; ++seed) {
    const World world(seed, 4e-4, 0.01);
    whole += LargestMove(world.graph, world.Solved(0.0));
    cut += LargestMove(world.graph, world.Solved(10.0));
  }
  EXPECT_LT(cut, 0.7 * whole);
}

TEST(CutMaps, WithoutABowlTilesAreNoWorseThanTheirNoise) {
  double sum = 0.0;
  constexpr int kTrials = 20;
  for (std::uint64_t seed = 10; seed < 10 + kTrials; ++seed) {
    const World world(seed, 0.0, 0.02);
    const Graph cut = world.Solved(1.0);
    const Vector3d off =
        cut.poses[5].world_from_node.translation - world.graph.poses[5].world_from_node.translation;
    const Eigen::Matrix3d covariance = GraphCovariance(cut).Pose(5).topLeftCorner<3, 3>();
    sum += off.dot(covariance.ldlt().solve(off)) / 3.0;
  }
  // Chi-square of three degrees of freedom in each trial, three sigmas. It may be less: ties allow
  // for a bowl.
  EXPECT_LT(sum / kTrials, 1.0 + 3.0 * std::sqrt(2.0 / (3.0 * kTrials)));
}

TEST(CutMaps, TilesThatNothingSeesFollowTheirNeighbours) {
  World world(3, 0.0, 0.02);
  for (double x = 60.0; x < 160.0; x += 5.0) world.places.emplace_back(x, 0.0, 0.0);
  const Graph cut = world.Solved(1.0);
  const Vector3d far(150.0, 0.0, 0.0);
  const Sim3& last = cut.maps.back().world_from_map;
  EXPECT_LT((last * far - far).norm(), 0.5);
  const Matrix7d covariance = GraphCovariance(cut).Map(static_cast<int>(cut.maps.size()) - 1);
  const double sigma = SigmaOfPlace(covariance, last, far);
  EXPECT_GT(sigma,
            SigmaOfPlace(GraphCovariance(cut).Map(0), cut.maps[0].world_from_map, world.places[0]));
  EXPECT_LT((last * far - far).norm(), 4.0 * sigma);
}

TEST(CutMaps, CamerasAndTheVerticalGoToTheTiles) {
  World world(4, 0.0, 0.02);
  MapFactor camera;
  camera.maps = {0};
  camera.point = camera.position = {-35.0, 0.0, 40.0};
  MapFactor up;
  up.type = "map_gravity";
  up.maps = {0};
  up.point = up.position = Vector3d::UnitZ();
  world.graph.map_factors = {camera, up};
  const Graph cut = world.Solved(1.0);
  Matrix7d information = Matrix7d::Zero();
  for (const MapFactor& factor : cut.map_factors) {
    if (factor.type == "map_gravity") information += factor.information;
    if (factor.type != "camera_position") continue;
    EXPECT_EQ(factor.maps[0],
              MapGrid(Tiling(20.0), Surfaces(world.places, {}), {}, "").TileAt(camera.point));
  }
  EXPECT_LT((information - up.information).norm(), 1e-12) << "counted once";
}

TEST(CutMaps, OpenMotionsAreOfTheMapAndNotOfItsTiles) {
  const World world(5, 0.0, 0.02);
  const Graph cut = world.Solved(1.0);
  EXPECT_EQ(GraphCovariance(cut).OpenMotions().size(),
            GraphCovariance(world.Solved(0.0)).OpenMotions().size());
}

}  // namespace
}  // namespace planegraph
