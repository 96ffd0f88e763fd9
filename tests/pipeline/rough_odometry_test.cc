// Scans whose poses are known roughly only, each with an error of its own.
#include <gtest/gtest.h>

#include "pipeline/small_site.h"
#include "planegraph/base/angles.h"
#include "planegraph/geometry/rotation.h"

namespace planegraph {
namespace {

Rigid3 Disturb(const Rigid3& pose, Random* random) {
  const auto vector = [&] {
    const double x = random->Normal(), y = random->Normal(), z = random->Normal();
    return Eigen::Vector3d(x, y, z);
  };
  const Eigen::Vector3d axis = vector().normalized();
  return {ExpSO3(5.0 * kDegree * axis) * pose.rotation, pose.translation + 0.3 * vector()};
}

class RoughOdometry : public TestFolder, public testing::WithParamInterface<std::uint64_t> {
 protected:
  std::vector<Rigid3> Poses(const SimulatedSite& site, const std::string& name) {
    WriteSite(Path(name), site);
    return MapScans(ReadSite(Path(name + "/site.yaml")), TwoThreads()).solution.world_from_scan;
  }
};

TEST_P(RoughOdometry, DoesNotMoveTheResult) {
  SimulatedSite site = SmallSite(SceneKind::kYard, 8, 12, GetParam());
  const std::vector<Rigid3> smooth = Poses(site, "smooth");
  Random random(GetParam(), 77);
  for (Rigid3& pose : site.robots.front().odometry) pose = Disturb(pose, &random);
  EXPECT_LT(LargestDistance(Poses(site, "rough"), smooth), 0.02);
}

INSTANTIATE_TEST_SUITE_P(Seeds, RoughOdometry, testing::Values(1, 2, 3));

}  // namespace
}  // namespace planegraph
