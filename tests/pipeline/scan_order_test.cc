// The order of a robot's scan files, whose odometry has time stamps, changes nothing.
#include <gtest/gtest.h>

#include "pipeline/small_site.h"

namespace planegraph {
namespace {

Site Permuted(const Site& site, const std::vector<std::size_t>& order) {
  Site permuted = site;
  RobotSite& robot = permuted.robots[0];
  for (std::size_t k = 0; k < order.size(); ++k) {
    robot.scans[k] = site.robots[0].scans[order[k]];
    robot.odometry->times[k] = site.robots[0].odometry->times[order[k]];
    robot.odometry->poses[k] = site.robots[0].odometry->poses[order[k]];
  }
  return permuted;
}

// As if the robot had come by in that order.
Site Revisited(const Site& site, const std::vector<std::size_t>& order) {
  Site revisited = Permuted(site, order);
  revisited.robots[0].odometry->times = site.robots[0].odometry->times;
  return revisited;
}

// Poses by file, seen from one of them.
std::vector<Rigid3> PosesFrom(const MapResult& result, std::size_t file) {
  std::vector<Rigid3> poses;
  for (const std::size_t i : ScansInFileOrder(result, 0)) {
    poses.push_back(result.solution.world_from_scan[i]);
  }
  const Rigid3 from_world = poses[file].Inverse();
  for (Rigid3& pose : poses) pose = from_world * pose;
  return poses;
}

class ScanOrder : public TestFolder {};
class ScanOrderOf : public ScanOrder, public testing::WithParamInterface<const char*> {};

TEST_P(ScanOrderOf, FilesChangesNothing) {
  WriteSite(Path("hall"), SmallSite(SceneKind::kHall, 5, 24));
  const Site site = ReadSite(Path("hall/site.yaml"));
  const auto expected = PosesFrom(MapScans(site, TwoThreads(GetParam())), 0);
  for (const std::vector<std::size_t>& order :
       {std::vector<std::size_t>{4, 3, 2, 1, 0}, {2, 0, 4, 1, 3}}) {
    const MapResult result = MapScans(Permuted(site, order), TwoThreads(GetParam()));
    std::size_t first = 0;
    while (order[first] != 0) ++first;
    const auto found = PosesFrom(result, first);
    for (std::size_t k = 0; k < order.size(); ++k) {
      EXPECT_EQ(result.scans[ScansInFileOrder(result, 0)[k]].index, k);
      EXPECT_LT((found[k].translation - expected[order[k]].translation).norm(), 1e-6) << k;
      EXPECT_LT(found[k].rotation.angularDistance(expected[order[k]].rotation), 1e-6) << k;
    }
  }
}

// What is registered to what is found by overlap, so that a joint graph hardly knows the order of
// the way; its odometry, of other steps then, is weak beside the planes.
TEST_F(ScanOrder, OfTheWayChangesTheGraphByLessThanAMillimetre) {
  WriteSite(Path("hall"), SmallSite(SceneKind::kHall, 5, 24));
  const Site site = ReadSite(Path("hall/site.yaml"));
  const auto expected = PosesFrom(MapScans(site, TwoThreads("graph")), 0);
  const std::vector<std::size_t> order = {2, 0, 4, 1, 3};
  const auto found = PosesFrom(MapScans(Revisited(site, order), TwoThreads("graph")), 1);
  for (std::size_t k = 0; k < order.size(); ++k) {
    EXPECT_LT((found[k].translation - expected[order[k]].translation).norm(), 1e-3) << k;
  }
}

INSTANTIATE_TEST_SUITE_P(Optimizers, ScanOrderOf, testing::Values("graph", "metascan"));

}  // namespace
}  // namespace planegraph
