#include "solve/selected_inverse.h"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <Eigen/SparseCholesky>
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

TEST(SelectedInverse, HasTheBlocksOfTheDenseInverse) {
  const std::vector<int> first_row = {0, 6, 12, 19, 25, 26, 32, 38, 44};
  for (const double share : {0.0, 0.2, 0.5, 1.0}) {
    const Eigen::MatrixXd matrix = RandomBlocks(first_row, share, 5);
    const Eigen::MatrixXd inverse = matrix.inverse();
    Eigen::SparseMatrix<double> sparse = matrix.sparseView();
    Eigen::SimplicialLLT<Eigen::SparseMatrix<double>, Eigen::Lower, Eigen::NaturalOrdering<int>>
        cholesky(sparse);
    ASSERT_EQ(cholesky.info(), Eigen::Success);
    const SelectedInverse selected(cholesky.matrixL().nestedExpression(), first_row);
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
    const Eigen::SparseMatrix<double> sparse = matrix.sparseView();
    const Eigen::SparseMatrix<double> lower =
        Eigen::MatrixXd(scatter.triangularView<Eigen::Lower>()).sparseView();
    Eigen::SimplicialLLT<Eigen::SparseMatrix<double>, Eigen::Lower, Eigen::NaturalOrdering<int>>
        cholesky(sparse);
    ASSERT_EQ(cholesky.info(), Eigen::Success);
    const SelectedInverse inverse(cholesky.matrixL().nestedExpression(), first_row);
    const SelectedSandwich selected(cholesky.matrixL().nestedExpression(), first_row, lower,
                                    inverse);
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
