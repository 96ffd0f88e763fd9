// Where a drone map knows that the air is free.
#include "planegraph/correspondence/open_sky.h"

#include <gtest/gtest.h>

#include "planegraph/geometry/rotation.h"

namespace planegraph {
namespace {

Surfel MakeSurfel(const Eigen::Vector3d& mean, const Eigen::Vector3d& normal, double size) {
  Surfel surfel{};
  surfel.mean = mean;
  surfel.normal = normal;
  surfel.axis1 = normal.unitOrthogonal();
  surfel.axis2 = normal.cross(surfel.axis1);
  surfel.size = size;
  surfel.area = size * size;
  surfel.segment = -1;
  return surfel;
}

// Ground of 20 m x 20 m at height 0, a house of 4 m x 4 m and 5 m height in its middle.
std::vector<Surfel> HouseOnGround(const Rigid3& map_from_world = Rigid3()) {
  std::vector<Surfel> surfels;
  const auto add = [&](const Eigen::Vector3d& mean, const Eigen::Vector3d& normal) {
    surfels.push_back(MakeSurfel(map_from_world * mean, map_from_world.rotation * normal, 1.0));
  };
  for (double x = -9.5; x < 10.0; x += 1.0) {
    for (double y = -9.5; y < 10.0; y += 1.0) {
      const bool house = std::abs(x) < 2.0 && std::abs(y) < 2.0;
      add({x, y, house ? 5.0 : 0.0}, Eigen::Vector3d::UnitZ());
    }
  }
  for (double y = -1.5; y < 2.0; y += 1.0) {
    for (double z = 0.5; z < 5.0; z += 1.0) {
      add({2.0, y, z}, Eigen::Vector3d::UnitX());
      add({-2.0, y, z}, -Eigen::Vector3d::UnitX());
    }
  }
  return surfels;
}

TEST(OpenSky, TheAirAboveWhatFacesUpIsFree) {
  const OpenSky sky(HouseOnGround());
  ASSERT_TRUE(sky.known());
  EXPECT_TRUE(sky.Free({6, 6, 2}));
  EXPECT_TRUE(sky.Free({0.2, 0.2, 7}));
  EXPECT_FALSE(sky.Free({6, 6, 0.1}));    // on the ground
  EXPECT_FALSE(sky.Free({6, 6, -2}));     // below it
  EXPECT_FALSE(sky.Free({0.2, 0.2, 2}));  // within the house
  EXPECT_FALSE(sky.Free({30, 6, 2}));     // where the map ends
}

TEST(OpenSky, AWallIsInTheOpenWhereBothItsSidesAre) {
  const OpenSky sky(HouseOnGround());
  const Eigen::Vector3d x = Eigen::Vector3d::UnitX();
  EXPECT_TRUE(sky.Open({7, 0, 2}, x));
  EXPECT_FALSE(sky.Open({2.1, 0, 2}, x));  // the house's own wall, a little off
  EXPECT_FALSE(sky.Open({1.0, 0, 2}, x));  // inside
  EXPECT_TRUE(sky.Open({7, 0, 2}, Eigen::Vector3d::UnitZ()));
  EXPECT_FALSE(sky.Open({7, 0, 0}, Eigen::Vector3d::UnitZ()));
}

TEST(OpenSky, UpFollowsTheMap) {
  const Rigid3 motion{ExpSO3({1.2, -0.7, 0.4}), {100, -20, 7}};
  const OpenSky sky(HouseOnGround(motion));
  EXPECT_TRUE(sky.Free(motion * Eigen::Vector3d(6, 6, 2)));
  EXPECT_FALSE(sky.Free(motion * Eigen::Vector3d(6, 6, -2)));
  EXPECT_FALSE(sky.Free(motion * Eigen::Vector3d(0.2, 0.2, 2)));
}

TEST(OpenSky, SurfacesThatMayFaceEitherWaySayNothing) {
  std::vector<Surfel> surfels = HouseOnGround();
  for (std::size_t k = 0, n = surfels.size(); k < n; ++k) {
    surfels.push_back(surfels[k]);
    surfels.back().normal *= -1.0;
  }
  const OpenSky sky(surfels);
  EXPECT_FALSE(sky.known());
  EXPECT_FALSE(sky.Free({6, 6, 2}));
  EXPECT_FALSE(OpenSky({}).known());
}

}  // namespace
}  // namespace planegraph
