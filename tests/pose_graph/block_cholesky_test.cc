#include "pose_graph/block_cholesky.h"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <random>

namespace planegraph {
namespace {

// A random positive definite matrix of 3 x 3 blocks over a random graph, pairs in either order and
// some of them twice.
TEST(BlockCholesky, SolvesAsADenseFactorization) {
  std::mt19937_64 rng(1);
  std::normal_distribution<double> normal;
  const auto random = [&] {
    return Eigen::Matrix3d::NullaryExpr([&](auto...) { return normal(rng); }).eval();
  };
  const int size = 40;
  std::vector<std::pair<int, int>> pairs;
  for (int i = 0; i + 1 < size; ++i) pairs.emplace_back(i, i + 1);
  for (int k = 0; k < 30; ++k) {
    const int a = static_cast<int>(rng() % size), b = static_cast<int>(rng() % size);
    if (a != b) pairs.emplace_back(a, b);
  }
  pairs.emplace_back(5, 4);
  const BlockPattern pattern(size, pairs);
  BlockCholesky sparse(pattern, 3);
  Eigen::MatrixXd dense = Eigen::MatrixXd::Zero(3 * size, 3 * size);
  for (std::size_t k = 0; k < pairs.size(); ++k) {
    const Eigen::Matrix3d block = random();
    sparse.AddPair<3>(static_cast<int>(k), block);
    dense.block<3, 3>(3 * pairs[k].first, 3 * pairs[k].second) += block;
    dense.block<3, 3>(3 * pairs[k].second, 3 * pairs[k].first) += block.transpose();
  }
  for (int i = 0; i < size; ++i) {
    sparse.Diagonal<3>(i).diagonal().array() += 40.0;
    dense.diagonal().segment<3>(3 * i).array() += 40.0;
  }
  const Eigen::MatrixXd b =
      Eigen::MatrixXd::NullaryExpr(3 * size, 2, [&](auto...) { return normal(rng); });
  ASSERT_TRUE(sparse.Factorize());
  EXPECT_LT((sparse.Solve(b) - dense.llt().solve(b)).norm(), 1e-10);
}

TEST(BlockCholesky, RefusesAnIndefiniteMatrix) {
  const BlockPattern pattern(2, {{0, 1}});
  BlockCholesky matrix(pattern, 2);
  matrix.Diagonal<2>(0).setIdentity();
  matrix.Diagonal<2>(1).setIdentity();
  EXPECT_TRUE(matrix.Factorize());
  matrix.AddPair<2>(0, 2.0 * Eigen::Matrix2d::Identity());
  EXPECT_FALSE(matrix.Factorize());
  matrix.SetZero();
  matrix.DiagonalBlock(0).setIdentity();
  matrix.DiagonalBlock(1).setIdentity();
  matrix.AddPairBlock(0, 0.5 * Eigen::Matrix2d::Identity());
  EXPECT_TRUE(matrix.Factorize());
}

}  // namespace
}  // namespace planegraph
