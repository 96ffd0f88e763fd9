#include "pipeline/open_directions.h"

#include <gmock/gmock.h>

namespace planegraph {
namespace {

const Eigen::Vector3d kAlong = Eigen::Vector3d::UnitX();

PairRecord Pair(std::size_t target, std::size_t source, const std::vector<Eigen::Vector3d>& open) {
  PairRecord pair{target, source, {}, true, 0.0};
  pair.registration.status =
      open.empty() ? RegistrationStatus::kOk : RegistrationStatus::kDegenerate;
  for (const Eigen::Vector3d& direction : open) {
    UnobservedDirection unobserved;
    unobserved.direction.head<3>() = direction;
    pair.registration.unobserved.push_back(unobserved);
  }
  return pair;
}

class OpenDirections : public testing::Test {
 protected:
  // Scan k stands turned by k times 40 degrees about the vertical: directions are compared in the
  // world's axes.
  OpenDirections() {
    for (int k = 0; k < 3; ++k) {
      const Eigen::AngleAxisd turn(0.7 * k, Eigen::Vector3d::UnitZ());
      solution_.world_from_scan.push_back({Eigen::Quaterniond(turn), {1.0 * k, 0, 0}});
    }
    odometry_ = {{0, 1, {}, Matrix6d::Identity()}, {1, 2, {}, Matrix6d::Identity()}};
  }

  Eigen::Vector3d InScan(int scan, const Eigen::Vector3d& in_world) const {
    return solution_.world_from_scan[scan].rotation.conjugate() * in_world;
  }

  std::vector<PoseFactor> Held(const std::vector<PairRecord>& pairs) {
    JointProblem problem;
    const std::vector<ScanRecord> scans(3);
    const std::vector<MapRecord> maps;
    const std::vector<MapPairRecord> map_pairs;
    problem.scans = &scans;
    problem.pairs = &pairs;
    problem.odometry = &odometry_;
    problem.maps = &maps;
    problem.map_pairs = &map_pairs;
    Graph graph;
    HoldOpenDirections(problem, solution_, &graph);
    return graph.pose_factors;
  }

  JointSolution solution_;
  std::vector<OdometryStep> odometry_;
};

TEST_F(OpenDirections, OdometryHoldsWhatAllPairsLeaveOpen) {
  const auto held =
      Held({Pair(0, 1, {kAlong}), Pair(1, 2, {InScan(1, kAlong)}), Pair(0, 2, {kAlong})});
  ASSERT_THAT(held, testing::SizeIs(2));
  EXPECT_GT(held[0].information(0, 0), 1e5);
  EXPECT_EQ(held[0].information(1, 1), 0.0);
  EXPECT_EQ(held[1].poses, (std::vector<int>{1, 2}));
}

TEST_F(OpenDirections, NothingIsOpenThatOtherPairsTie) {
  EXPECT_THAT(Held({Pair(0, 1, {kAlong}), Pair(1, 2, {}), Pair(0, 2, {})}), testing::IsEmpty());
}

TEST_F(OpenDirections, PairsThatLeaveTheSameDirectionOpenTieNothing) {
  EXPECT_THAT(Held({Pair(0, 1, {kAlong}), Pair(1, 2, {InScan(1, kAlong)}), Pair(0, 2, {})}),
              testing::SizeIs(2));
}

TEST_F(OpenDirections, PairsThatLeaveAnotherDirectionOpenTie) {
  const Eigen::Vector3d across = Eigen::Vector3d::UnitY();
  const auto held =
      Held({Pair(0, 1, {kAlong}), Pair(1, 2, {InScan(1, across)}), Pair(0, 2, {across})});
  // Scan 2 is tied to the others along the first direction only.
  ASSERT_THAT(held, testing::SizeIs(1));
  EXPECT_EQ(held[0].poses, (std::vector<int>{1, 2}));
}

TEST_F(OpenDirections, ADirectionInAnOpenPlaneIsOpen) {
  const Eigen::Vector3d a = Eigen::Vector3d(1, 1, 0).normalized();
  const Eigen::Vector3d b = Eigen::Vector3d(1, -1, 0).normalized();
  EXPECT_THAT(Held({Pair(0, 1, {kAlong}), Pair(1, 2, {}), Pair(0, 2, {a, b})}), testing::SizeIs(1));
}

}  // namespace
}  // namespace planegraph
