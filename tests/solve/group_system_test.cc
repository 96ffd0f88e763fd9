#include "solve/group_system.h"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <algorithm>
#include <random>

namespace planegraph {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

// Two planes that three poses see, and a factor that ties them.
class TiedPlanes {
 public:
  TiedPlanes() : graph_(ThreePoses()), numbers_(graph_), information_(numbers_) {
    for (int pose = 0; pose < 3; ++pose) {
      for (int plane = 0; plane < 2; ++plane) {
        residuals_.push_back(Random({{BlockKind::kPlane, plane}, {BlockKind::kPose, pose}}));
      }
    }
    residuals_.push_back(Random({{BlockKind::kPlane, 0}, {BlockKind::kPlane, 1}}));
  }

  const PoseInformation& numbers() const { return information_; }
  std::vector<const PlaneResidual*> All() const {
    std::vector<const PlaneResidual*> all;
    for (const PlaneResidual& residual : residuals_) all.push_back(&residual);
    return all;
  }
  // The Jacobians of all residuals by the planes, or by the poses.
  MatrixXd Stacked(BlockKind kind) const {
    MatrixXd all = MatrixXd::Zero(kRows * residuals_.size(), kind == BlockKind::kPlane ? 6 : 18);
    for (std::size_t i = 0; i < residuals_.size(); ++i) {
      const PlaneResidual& residual = residuals_[i];
      for (std::size_t k = 0; k < residual.blocks.size(); ++k) {
        if (residual.blocks[k].kind != kind) continue;
        const MatrixXd& jacobian = residual.linear.jacobians[k];
        all.block(kRows * i, residual.blocks[k].index * jacobian.cols(), kRows, jacobian.cols()) =
            jacobian;
      }
    }
    return all;
  }
  VectorXd Scatter() const {
    VectorXd all(kRows * residuals_.size());
    for (std::size_t i = 0; i < residuals_.size(); ++i) {
      all.segment<kRows>(kRows * i) = residuals_[i].scatter;
    }
    return all;
  }

 private:
  static constexpr int kRows = 3;

  static Graph ThreePoses() {
    Graph graph;
    graph.poses.resize(3);
    return graph;
  }
  MatrixXd Random(int rows, int columns) {
    return MatrixXd::NullaryExpr(rows, columns, [this] { return normal_(rng_); });
  }
  PlaneResidual Random(std::vector<BlockRef> blocks) {
    PlaneResidual residual;
    for (const BlockRef& block : blocks) {
      residual.linear.jacobians.push_back(Random(kRows, block.kind == BlockKind::kPlane ? 3 : 6));
    }
    residual.blocks = std::move(blocks);
    residual.linear.residual = Random(kRows, 1);
    residual.scatter = Random(kRows, 1).cwiseAbs2();
    return residual;
  }

  std::mt19937_64 rng_{4};
  std::normal_distribution<double> normal_;
  Graph graph_;
  NodeNumbers numbers_;
  PoseInformation information_;
  std::vector<PlaneResidual> residuals_;
};

// By the orthogonal projection of the poses' columns away from those of the planes.
TEST(GroupSystem, TakesWhatTheProjectionTakes) {
  const TiedPlanes world;
  const GroupSystem system(world.All(), world.numbers());
  const MatrixXd planes = world.Stacked(BlockKind::kPlane), poses = world.Stacked(BlockKind::kPose);
  const MatrixXd left = poses - planes * planes.colPivHouseholderQr().solve(poses);
  ASSERT_EQ(system.rows(), 18);
  EXPECT_TRUE(
      (poses.transpose() * poses + system.Reduction()).isApprox(left.transpose() * left, 1e-10));
  const Eigen::DiagonalMatrix<double, Eigen::Dynamic> scatter(world.Scatter());
  EXPECT_TRUE((poses.transpose() * scatter * poses + system.ScatterReduction())
                  .isApprox(left.transpose() * scatter * left, 1e-10));
}

TEST(GroupSystem, APlaneFollowsThePosesByLeastSquares) {
  const TiedPlanes world;
  const GroupSystem system(world.All(), world.numbers());
  const MatrixXd planes = world.Stacked(BlockKind::kPlane), poses = world.Stacked(BlockKind::kPose);
  const MatrixXd follow = -planes.colPivHouseholderQr().solve(poses);
  const MatrixXd solve = planes.completeOrthogonalDecomposition().pseudoInverse();
  const Eigen::DiagonalMatrix<double, Eigen::Dynamic> scatter(world.Scatter());
  for (const int plane : {0, 1}) {
    const PlaneElimination found = system.Eliminate(plane);
    EXPECT_TRUE(found.determined);
    const MatrixXd rows = solve.middleRows<3>(3 * plane);
    EXPECT_TRUE(found.covariance.isApprox(rows * scatter * rows.transpose(), 1e-10));
    ASSERT_EQ(found.by_nodes.size(), 3u);
    for (const auto& [node, by_node] : found.by_nodes) {
      EXPECT_TRUE(by_node.isApprox(follow.block(3 * plane, 6 * node, 3, 6), 1e-10)) << node;
    }
  }
}

TEST(GroupSystem, TheOrderOfTheResidualsDoesNotMatter) {
  const TiedPlanes world;
  std::vector<const PlaneResidual*> turned = world.All();
  std::reverse(turned.begin(), turned.end());
  const GroupSystem a(world.All(), world.numbers()), b(turned, world.numbers());
  const MatrixXd of_a = a.Reduction(), of_b = b.Reduction();
  for (const auto& [i, row] : a.nodes()) {
    for (const auto& [j, column] : a.nodes()) {
      const MatrixXd other = of_b.block(b.nodes().at(i).first, b.nodes().at(j).first, 6, 6);
      EXPECT_TRUE(of_a.block(row.first, column.first, 6, 6).isApprox(other, 1e-10));
    }
  }
}

// One residual of three rows, of which one is none, leaves a direction of the plane open: the plane
// is not determined, and takes no more than what it was told.
TEST(GroupSystem, APlaneThatIsNotHeldTakesNothingThere) {
  const TiedPlanes world;
  PlaneResidual weak = *world.All().front();
  for (MatrixXd& jacobian : weak.linear.jacobians) jacobian.row(2).setZero();
  const GroupSystem system({&weak}, world.numbers());
  EXPECT_FALSE(system.Eliminate(0).determined);
  const MatrixXd& by_pose = weak.linear.jacobians[1];
  // Two rows and three unknowns: whatever the pose says, the plane follows.
  EXPECT_LT((by_pose.transpose() * by_pose + system.Reduction()).norm(), 1e-9);
  EXPECT_TRUE(system.Eliminate(7).by_nodes.empty()) << "a plane of another group";
}

}  // namespace
}  // namespace planegraph
