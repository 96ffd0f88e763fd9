#include "solve/selected_inverse.h"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <random>

#include "solve/plane_world.h"
#include "solve/pose_system.h"

namespace planegraph {
namespace {

// A positive matrix of blocks of different sizes, of which a share is there.
Eigen::MatrixXd RandomBlocks(const std::vector<int>& first_row, double share, std::uint64_t seed) {
  std::mt19937_64 rng(seed);
  std::normal_distribution<double> normal;
  const int rows = first_row.back();
  Eigen::MatrixXd matrix = Eigen::MatrixXd::Zero(rows, rows);
  for (std::size_t a = 0; a + 1 < first_row.size(); ++a) {
    for (std::size_t b = 0; b <= a; ++b) {
      if (a != b && std::uniform_real_distribution<double>()(rng) > share) continue;
      for (int r = first_row[a]; r < first_row[a + 1]; ++r) {
        for (int c = first_row[b]; c < first_row[b + 1]; ++c) {
          matrix(r, c) = matrix(c, r) = normal(rng);
        }
      }
    }
  }
  return matrix + 2.0 * rows * Eigen::MatrixXd::Identity(rows, rows);
}

Eigen::SparseMatrix<double> LowerOf(const Eigen::MatrixXd& matrix) {
  return Eigen::MatrixXd(matrix.triangularView<Eigen::Lower>()).sparseView();
}

FactorStructure StructureOf(const Eigen::MatrixXd& matrix, const std::vector<int>& first_row) {
  const std::size_t nodes = first_row.size() - 1;
  std::vector<std::vector<int>> below(nodes);
  for (std::size_t b = 0; b < nodes; ++b) {
    for (std::size_t a = nodes - 1; a > b; --a) {
      const int r = first_row[a], c = first_row[b];
      if (matrix.block(r, c, first_row[a + 1] - r, first_row[b + 1] - c).isZero(0.0)) continue;
      below[b].push_back(static_cast<int>(a));
    }
  }
  return FactorStructure(first_row, below);
}

// A long chain of nodes with ways across: wide columns and narrow ones, and rows of a part of them.
TEST(BlockFactor, SolvesAndIsTheDenseFactor) {
  std::vector<int> first_row = {0};
  std::mt19937_64 rng(8);
  for (int node = 0; node < 60; ++node) first_row.push_back(first_row.back() + 1 + rng() % 7);
  for (const double share : {0.0, 0.03, 0.1, 0.5, 1.0}) {
    const Eigen::MatrixXd matrix = RandomBlocks(first_row, share, 6);
    const FactorStructure structure = StructureOf(matrix, first_row);
    BlockFactor factor(structure);
    ASSERT_TRUE(factor.Factorize(LowerOf(matrix)));
    const Eigen::MatrixXd right = Eigen::MatrixXd::Random(matrix.rows(), 5);
    EXPECT_LT((matrix * factor.Solve(right) - right).norm(), 1e-12 * right.norm());
    const Eigen::MatrixXd dense = matrix.llt().matrixL();
    for (int a = 0; a < 60; ++a) {
      for (int b = 0; b < a; ++b) {
        const auto expected =
            dense.block(first_row[a], first_row[b], first_row[a + 1] - first_row[a],
                        first_row[b + 1] - first_row[b]);
        if (factor.columns().Has(a, b)) {
          EXPECT_LT((factor.columns().Block(a, b) - expected).norm(), 1e-12 * dense.norm());
        } else {
          EXPECT_TRUE(expected.isZero(0.0));
        }
      }
    }
    EXPECT_FALSE(factor.Factorize(LowerOf(-matrix)));
  }
}

TEST(FactorStructure, JoinsNodesWithTheSameRowsBelow) {
  // 0 - 2, 1 - 2; 2, 3 and 4 among each other.
  const FactorStructure structure({0, 6, 12, 18, 25, 26}, {{2}, {2}, {4, 3}, {4}, {}});
  EXPECT_EQ(structure.column_of, (std::vector<int>{0, 1, 2, 2, 2}));
  EXPECT_EQ(structure.rows, (std::vector<std::vector<int>>{{0, 2}, {1, 2}, {2, 3, 4}}));
}

TEST(SelectedInverse, HasTheBlocksOfTheDenseInverse) {
  const std::vector<int> first_row = {0, 6, 12, 19, 25, 26, 32, 38, 44};
  for (const double share : {0.0, 0.2, 0.5, 1.0}) {
    const Eigen::MatrixXd matrix = RandomBlocks(first_row, share, 5);
    const Eigen::MatrixXd inverse = matrix.inverse();
    const FactorStructure structure = StructureOf(matrix, first_row);
    BlockFactor factor(structure);
    ASSERT_TRUE(factor.Factorize(LowerOf(matrix)));
    const SelectedInverse selected(factor);
    int found = 0;
    for (int a = 0; a < 8; ++a) {
      for (int b = 0; b <= a; ++b) {
        const int r = first_row[a], c = first_row[b];
        const int rows = first_row[a + 1] - r, columns = first_row[b + 1] - c;
        const bool in_matrix = !matrix.block(r, c, rows, columns).isZero(0.0);
        EXPECT_TRUE(selected.Has(a, b) || !in_matrix);
        if (!selected.Has(a, b)) continue;
        ++found;
        const Eigen::MatrixXd expected = inverse.block(r, c, rows, columns);
        EXPECT_LT((selected.Block(a, b) - expected).norm(), 1e-12 * inverse.norm());
        EXPECT_LT((selected.Block(b, a) - expected.transpose()).norm(), 1e-12 * inverse.norm());
      }
    }
    EXPECT_GE(found, 8);
    EXPECT_TRUE(share > 0.0 || found == 8);
    EXPECT_TRUE(share < 1.0 || found == 36);
  }
}

TEST(SelectedSandwich, HasTheBlocksOfTheDenseProduct) {
  const std::vector<int> first_row = {0, 6, 12, 19, 25, 26, 32, 38, 44};
  for (const double share : {0.0, 0.2, 0.5, 1.0}) {
    const Eigen::MatrixXd matrix = RandomBlocks(first_row, share, 5);
    // Other numbers at the same places.
    const Eigen::MatrixXd scatter =
        matrix.cwiseProduct(RandomBlocks(first_row, 1.0, 9)) / first_row.back();
    const Eigen::MatrixXd expected = matrix.inverse() * scatter * matrix.inverse();
    const FactorStructure structure = StructureOf(matrix, first_row);
    BlockFactor factor(structure);
    ASSERT_TRUE(factor.Factorize(LowerOf(matrix)));
    const SelectedInverse inverse(factor);
    const SelectedSandwich selected(factor, LowerOf(scatter), inverse);
    for (int a = 0; a < 8; ++a) {
      for (int b = 0; b < 8; ++b) {
        if (!inverse.Has(std::max(a, b), std::min(a, b))) continue;
        const Eigen::MatrixXd block =
            expected.block(first_row[a], first_row[b], first_row[a + 1] - first_row[a],
                           first_row[b + 1] - first_row[b]);
        EXPECT_LT((selected.Block(a, b) - block).norm(), 1e-12 * expected.norm());
      }
    }
  }
}

// A long way on which each pose sees planes of its neighbours: blocks come from the elimination or
// from a solve, and are the same.
TEST(SelectedInverse, ItsBlocksAreThoseOfASolve) {
  PlaneWorld world({.poses = 12, .planes = 120, .seen_share = 0.9});
  Graph graph = world.truth();
  for (PlaneLandmark& plane : graph.planes) {
    const int first = plane.user_tag % 11;
    std::erase_if(plane.observations, [&](const PlaneObservation& seen) {
      return seen.pose < first || seen.pose > first + 1;
    });
  }
  std::erase_if(graph.planes, [](const auto& plane) { return plane.observations.empty(); });
  PoseInformation information{NodeNumbers(graph)};
  AddAllPlaneInformation(LinearizeGraph(graph, {}), &information);
  const PoseSystem system(information, GaugeFixed(graph, true));
  EXPECT_TRUE(system.Block(0, 3).isZero(0.0));  // held
  for (int a = 1; a < 12; ++a) {
    Eigen::MatrixXd unit = Eigen::MatrixXd::Zero(system.rows(), 6);
    unit.middleRows<6>(6 * a).setIdentity();
    const Eigen::MatrixXd solved = system.Solve(unit);
    for (int b = 1; b < 12; ++b) {
      const Eigen::MatrixXd expected = solved.middleRows<6>(6 * b);
      const double size = std::sqrt(system.Block(a, a).norm() * system.Block(b, b).norm());
      EXPECT_LT((system.Block(b, a) - expected).norm(), 1e-9 * size) << a << ", " << b;
    }
  }
}

}  // namespace
}  // namespace planegraph
