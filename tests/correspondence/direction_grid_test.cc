#include "correspondence/direction_grid.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "planegraph/geometry/rotation.h"

namespace planegraph {
namespace {

using Eigen::Vector3d;

constexpr double kVoxel = 0.8;

Surfel MakeSurfel(const Vector3d& mean, const Vector3d& normal) {
  Surfel s;
  s.mean = mean;
  s.normal = normal;
  const auto basis = TangentBasis(normal);
  s.axis1 = basis.col(0), s.axis2 = basis.col(1);
  s.variance1 = s.variance2 = s.offset_variance = 1e-4;
  s.size = 0.8;
  s.area = s.size * s.size;
  s.segment = -1;
  return s;
}

// Surfaces at random in a box of 40 x 30 x 8 m, with normals of all kinds.
std::vector<Surfel> RandomSurfels(int count, std::uint64_t seed) {
  std::mt19937_64 engine(seed);
  std::uniform_real_distribution<double> uniform(0.0, 1.0);
  std::normal_distribution<double> normal;
  std::vector<Surfel> surfels;
  for (int k = 0; k < count; ++k) {
    const double x = 40.0 * uniform(engine), y = 30.0 * uniform(engine), z = 8.0 * uniform(engine);
    const double a = normal(engine), b = normal(engine), c = normal(engine);
    surfels.push_back(MakeSurfel({x, y, z}, Vector3d(a, b, c).normalized()));
  }
  return surfels;
}

// The first surfels as voters of a body that then lies at `translation`.
std::vector<DirectionGrid::Voter> VotersFor(const std::vector<Surfel>& surfels, std::size_t count,
                                            const Vector3d& translation) {
  std::vector<DirectionGrid::Voter> voters;
  for (std::size_t k = 0; k < count; ++k) {
    voters.push_back({surfels[k].mean - translation, DirectionGrid::ClassOf(surfels[k].normal)});
  }
  return voters;
}

DirectionGrid::Window All(const DirectionGrid& grid, double margin = 20.0) {
  return {grid.low() - Vector3d::Constant(margin), grid.high() + Vector3d::Constant(margin)};
}

TEST(DirectionGrid, VotesAreMostAtTheTranslation) {
  for (std::uint64_t seed = 1; seed <= 10; ++seed) {
    const auto surfels = RandomSurfels(300, seed);
    const DirectionGrid grid(surfels, kVoxel);
    std::mt19937_64 engine(seed);
    std::uniform_real_distribution<double> uniform(-15.0, 15.0);
    const double x = uniform(engine), y = uniform(engine), z = uniform(engine);
    const Vector3d truth(x, y, z);
    const auto votes = grid.Count(VotersFor(surfels, 60, truth), All(grid), 5);
    ASSERT_FALSE(votes.empty());
    // The centre of the voxel that the translation is in, and its voters are rounded to voxels.
    EXPECT_LE((votes[0].translation - truth).cwiseAbs().maxCoeff(), kVoxel) << seed;
    EXPECT_GE(votes[0].count, 50) << "of 60";
    EXPECT_LE(votes[0].count, 60);
    EXPECT_LT(votes[1].count, 30) << "elsewhere surfaces meet by chance";
  }
}

TEST(DirectionGrid, VotesAreSortedAndNoNeighbours) {
  const auto surfels = RandomSurfels(300, 3);
  const DirectionGrid grid(surfels, kVoxel);
  const auto votes = grid.Count(VotersFor(surfels, 60, {1, 2, 3}), All(grid), 12);
  ASSERT_EQ(votes.size(), 12u);
  for (std::size_t a = 1; a < votes.size(); ++a) {
    EXPECT_LE(votes[a].count, votes[a - 1].count);
    for (std::size_t b = 0; b < a; ++b) {
      EXPECT_GT((votes[a].translation - votes[b].translation).cwiseAbs().maxCoeff(),
                1.4 * grid.voxel());
    }
  }
}

TEST(DirectionGrid, AMapThatMovesTakesItsVotesAlong) {
  auto surfels = RandomSurfels(200, 4);
  const DirectionGrid grid(surfels, kVoxel);
  const auto voters = VotersFor(surfels, 50, {1, -2, 0.5});
  const auto window = All(grid);
  // Dyadic numbers, so that the grid that begins at the map's lowest corner moves without rounding.
  for (const Vector3d& shift : {Vector3d(1024.0, -512.0, 64.0), Vector3d(0.25, 0.5, -0.125)}) {
    auto moved = surfels;
    for (Surfel& s : moved) s.mean += shift;
    const DirectionGrid moved_grid(moved, kVoxel);
    const auto before = grid.Count(voters, window, 5);
    const auto after = moved_grid.Count(voters, {window.low + shift, window.high + shift}, 5);
    ASSERT_EQ(after.size(), before.size());
    EXPECT_LT((after[0].translation - before[0].translation - shift).norm(), 1e-6);
    EXPECT_NEAR(after[0].count, before[0].count, 2);
  }
}

TEST(DirectionGrid, TheOrderOfMapAndVotersDoesNotMatter) {
  auto surfels = RandomSurfels(200, 5);
  auto voters = VotersFor(surfels, 50, {3, 1, -1});
  const DirectionGrid grid(surfels, kVoxel);
  const auto before = grid.Count(voters, All(grid), 5);
  std::reverse(surfels.begin(), surfels.end());
  std::reverse(voters.begin(), voters.end());
  const DirectionGrid reversed(surfels, kVoxel);
  const auto after = reversed.Count(voters, All(reversed), 5);
  ASSERT_EQ(after.size(), before.size());
  for (std::size_t k = 0; k < after.size(); ++k) {
    EXPECT_EQ(after[k].translation, before[k].translation);
    EXPECT_EQ(after[k].count, before[k].count);
  }
}

TEST(DirectionGrid, OnlySurfacesThatFaceAlikeCount) {
  const auto surfels = RandomSurfels(300, 6);
  const DirectionGrid grid(surfels, kVoxel);
  auto voters = VotersFor(surfels, 60, {2, 2, 2});
  for (std::size_t k = 0; k < voters.size(); ++k) {
    voters[k].direction = DirectionGrid::ClassOf(-surfels[k].normal);
  }
  const auto votes = grid.Count(voters, All(grid), 1);
  ASSERT_FALSE(votes.empty());
  EXPECT_LT(votes[0].count, 30);
}

TEST(DirectionGrid, TheWindowIsKept) {
  const auto surfels = RandomSurfels(300, 7);
  const DirectionGrid grid(surfels, kVoxel);
  const Vector3d truth(5, -3, 1);
  const auto voters = VotersFor(surfels, 60, truth);
  const DirectionGrid::Window about{truth.array() - 2.0, truth.array() + 2.0};
  const auto near = grid.Count(voters, about, 4);
  ASSERT_FALSE(near.empty());
  EXPECT_LE((near[0].translation - truth).cwiseAbs().maxCoeff(), kVoxel);
  const DirectionGrid::Window elsewhere{truth.array() + 4.0, truth.array() + 9.0};
  for (const auto& vote : grid.Count(voters, elsewhere, 50)) {
    for (int k = 0; k < 3; ++k) {
      EXPECT_GE(vote.translation[k], elsewhere.low[k] - kVoxel);
      EXPECT_LE(vote.translation[k], elsewhere.high[k] + kVoxel);
    }
  }
}

// Each voter by itself at a single translation: a way of counting that adds nothing up by bits.
int CountOneByOne(const DirectionGrid& grid, const std::vector<DirectionGrid::Voter>& voters,
                  const Vector3d& translation) {
  int count = 0;
  for (const auto& voter : voters) {
    const auto votes = grid.Count({voter}, {translation, translation}, 1);
    count += votes.empty() ? 0 : votes[0].count;
  }
  return count;
}

TEST(DirectionGrid, TogetherVotersCountAsEachByItself) {
  // Windows of all widths, inside the map, over its rim and beside it.
  std::mt19937_64 engine(11);
  std::uniform_real_distribution<double> uniform(0.0, 1.0);
  for (int run = 0; run < 40; ++run) {
    const auto surfels = RandomSurfels(150, 100 + run);
    const DirectionGrid grid(surfels, kVoxel);
    const auto voters = VotersFor(surfels, 1 + run, {30.0 * uniform(engine), 4.0, -2.0});
    const double x = 60.0 * uniform(engine) - 20.0, y = 60.0 * uniform(engine) - 20.0;
    const Vector3d low(x, y, -8.0), wide(40.0 * uniform(engine), 30.0 * uniform(engine), 12.0);
    const auto votes = grid.Count(voters, {low, low + wide}, 30);
    for (const auto& vote : votes) {
      EXPECT_EQ(vote.count, CountOneByOne(grid, voters, vote.translation)) << run;
    }
    // No translation has more votes than the best one.
    for (int k = 0; k < 50; ++k) {
      const double a = uniform(engine), b = uniform(engine), c = uniform(engine);
      const Vector3d any = low + Vector3d(a, b, c).cwiseProduct(wide);
      EXPECT_LE(CountOneByOne(grid, voters, any), votes.empty() ? 0 : votes[0].count) << run;
    }
  }
}

TEST(DirectionGrid, AWindowFarFromTheMapHoldsNoVotes) {
  const auto surfels = RandomSurfels(100, 8);
  const DirectionGrid grid(surfels, kVoxel);
  const Vector3d far(1000.0, 1000.0, 1000.0);
  EXPECT_TRUE(grid.Count(VotersFor(surfels, 20, {0, 0, 0}), {far, far.array() + 3.0}, 4).empty());
}

TEST(DirectionGrid, EmptyMapsAndNoVoters) {
  const DirectionGrid empty({}, kVoxel);
  const std::vector<DirectionGrid::Voter> one{{Vector3d::Zero(), 0}};
  EXPECT_TRUE(empty.Count(one, {Vector3d::Constant(-3.0), Vector3d::Constant(3.0)}, 4).empty());
  const auto surfels = RandomSurfels(10, 9);
  const DirectionGrid grid(surfels, kVoxel);
  EXPECT_TRUE(grid.Count({}, All(grid), 4).empty());
}

TEST(DirectionGrid, CountsSaturateRatherThanWrap) {
  // 400 voters on one surface: more than a byte holds.
  const std::vector<Surfel> surfels{MakeSurfel({1, 2, 3}, Vector3d::UnitZ())};
  const DirectionGrid grid(surfels, kVoxel);
  const std::vector<DirectionGrid::Voter> voters(
      400, {Vector3d::Zero(), DirectionGrid::ClassOf(Vector3d::UnitZ())});
  const auto votes = grid.Count(voters, All(grid, 2.0), 1);
  ASSERT_EQ(votes.size(), 1u);
  EXPECT_EQ(votes[0].count, 255);
}

TEST(DirectionGrid, AHugeMapGetsCoarserVoxels) {
  std::vector<Surfel> surfels{MakeSurfel({0, 0, 0}, Vector3d::UnitZ()),
                              MakeSurfel({3000, 3000, 100}, Vector3d::UnitZ())};
  const DirectionGrid grid(surfels, kVoxel);
  EXPECT_GT(grid.voxel(), kVoxel);
  const Vector3d cells = (grid.high() - grid.low()) / grid.voxel();
  EXPECT_LT(cells.prod(), 1.1 * (1 << 26));
}

TEST(DirectionGrid, ClassesTurnWithTheAxes) {
  // The classes are the 26 neighbours of a cube: turning a normal by 90 degrees permutes them.
  std::mt19937_64 engine(10);
  std::normal_distribution<double> normal;
  const Eigen::Matrix3d turn = ExpSO3({0, 0, 0.5 * EIGEN_PI}).toRotationMatrix();
  std::vector<int> image(DirectionGrid::kClasses, -1);
  for (int run = 0; run < 500; ++run) {
    const double a = normal(engine), b = normal(engine), c = normal(engine);
    const Vector3d n = Vector3d(a, b, c).normalized();
    const int from = DirectionGrid::ClassOf(n), to = DirectionGrid::ClassOf(turn * n);
    ASSERT_GE(from, 0);
    ASSERT_LT(from, DirectionGrid::kClasses);
    if (image[from] < 0) image[from] = to;
    EXPECT_EQ(image[from], to);
    EXPECT_NE(DirectionGrid::ClassOf(-n), from);
  }
}

}  // namespace
}  // namespace planegraph
