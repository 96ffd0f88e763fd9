#include "pipeline/camera_sides.h"

#include <gtest/gtest.h>

#include <random>

namespace planegraph {
namespace {

PlaneSet Level(const std::vector<Eigen::Vector3d>& places) {
  PlaneSet planes;
  for (const Eigen::Vector3d& place : places) {
    Patch patch;
    patch.moments.Add(place);
    patch.normal = Eigen::Vector3d::UnitZ();
    patch.orientation = Orientation::kUnknown;
    planes.patches.push_back(patch);
  }
  return planes;
}

TEST(OrientByCameras, PatchesFaceTheCameras) {
  PlaneSet planes = Level({{0, 0, 0}, {5, 0, 60}});
  OrientByCameras({{0, 0, 30}, {10, 5, 31}, {3, -9, 29}}, 1, &planes);
  EXPECT_EQ(planes.patches[0].normal, Eigen::Vector3d(0, 0, 1));
  EXPECT_EQ(planes.patches[1].normal, Eigen::Vector3d(0, 0, -1));
  for (const Patch& patch : planes.patches) EXPECT_EQ(patch.orientation, Orientation::kSensor);
}

TEST(OrientByCameras, NothingIsKnownWithCamerasOnBothSidesOrNone) {
  const std::vector<std::vector<Eigen::Vector3d>> nothing = {
      {}, {{0, 0, 9}, {0, 0, -9}}, {{7, 0, 0}}};
  for (const auto& centres : nothing) {
    PlaneSet planes = Level({{0, 0, 0}});
    OrientByCameras(centres, 1, &planes);
    EXPECT_EQ(planes.patches[0].orientation, Orientation::kUnknown);
    EXPECT_EQ(planes.patches[0].normal, Eigen::Vector3d(0, 0, 1));
  }
}

TEST(OrientByCameras, ACameraInAPatchSaysNothing) {
  const Eigen::Vector3d place(1, 2, 3);
  PlaneSet alone = Level({place}), below = Level({place});
  OrientByCameras({place}, 1, &alone);
  OrientByCameras({place, place - Eigen::Vector3d(0, 1, 5)}, 1, &below);
  EXPECT_EQ(alone.patches[0].orientation, Orientation::kUnknown);
  EXPECT_EQ(below.patches[0].orientation, Orientation::kSensor);
  EXPECT_EQ(below.patches[0].normal, Eigen::Vector3d(0, 0, -1));
}

// Neither the number of threads nor the side that a normal showed to before counts.
TEST(OrientByCameras, IsOneAnswer) {
  std::mt19937_64 engine(2);
  std::uniform_real_distribution<double> uniform(-20.0, 20.0);
  const auto place = [&] {
    return Eigen::Vector3d(uniform(engine), uniform(engine), uniform(engine));
  };
  std::vector<Eigen::Vector3d> places, centres;
  for (int i = 0; i < 500; ++i) places.push_back(place());
  for (int i = 0; i < 20; ++i) centres.push_back(place());
  PlaneSet one = Level(places), three = Level(places), turned = Level(places);
  for (Patch& patch : turned.patches) patch.normal = -patch.normal;
  OrientByCameras(centres, 1, &one);
  OrientByCameras(centres, 3, &three);
  OrientByCameras(centres, 1, &turned);
  int known = 0;
  for (std::size_t i = 0; i < places.size(); ++i) {
    EXPECT_EQ(three.patches[i].normal, one.patches[i].normal);
    EXPECT_EQ(turned.patches[i].orientation, one.patches[i].orientation);
    if (one.patches[i].orientation == Orientation::kUnknown) continue;
    ++known;
    EXPECT_EQ(turned.patches[i].normal, one.patches[i].normal);
  }
  EXPECT_GT(known, 50);
  EXPECT_LT(known, 500);
}

}  // namespace
}  // namespace planegraph
