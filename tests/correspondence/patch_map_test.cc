#include "planegraph/correspondence/patch_map.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "planegraph/segmentation/segmenter.h"
#include "segmentation/ray_world.h"

namespace planegraph {
namespace {

constexpr double kGate = 0.3, kCosine = 0.95;

// Whether a surfel may answer for a point, as the header has it: it faces alike, lies within the
// gate, and its cell, half as much again, reaches the point's foot.
bool MayAnswer(const Surfel& s, const Eigen::Vector3d& point, const Eigen::Vector3d& normal) {
  if (s.normal.dot(normal) < kCosine) return false;
  const Eigen::Vector3d d = point - s.mean;
  const double height = s.normal.dot(d);
  return std::abs(height) <= kGate && (d - height * s.normal).norm() <= 0.75 * s.size;
}

class PatchMapTest : public testing::Test {
 protected:
  PatchMapTest()
      : planes_(
            SegmentPlanes(ScanWorld(FurnishedRoom(5), MakePose(0, 0, 1.3, 0.3), 30000, {}, 2).cloud)
                .planes),
        map_(MakeSurfels(planes_)) {}

  PlaneSet planes_;
  PatchMap map_;
};

TEST_F(PatchMapTest, EveryPatchIsASurfelThatFindsItself) {
  ASSERT_EQ(map_.surfels().size(), planes_.patches.size());
  for (const Surfel& s : map_.surfels()) {
    const int found = map_.Find(s.mean, s.normal, kGate, kCosine);
    ASSERT_GE(found, 0);
    EXPECT_LE(std::abs(map_.surfels()[found].normal.dot(s.mean - map_.surfels()[found].mean)),
              0.06);
  }
}

TEST_F(PatchMapTest, AgreesWithASearchThroughAll) {
  std::mt19937_64 engine(4);
  std::normal_distribution<double> normal;
  std::uniform_int_distribution<std::size_t> any(0, map_.surfels().size() - 1);
  int answers = 0, lost = 0;
  for (int run = 0; run < 3000; ++run) {
    const Surfel& near = map_.surfels()[any(engine)];
    const auto jitter = [&] {
      return Eigen::Vector3d(normal(engine), normal(engine), normal(engine));
    };
    const Eigen::Vector3d point = near.mean + 0.2 * jitter();
    const Eigen::Vector3d direction = (near.normal + 0.05 * jitter()).normalized();
    double least = INFINITY;
    for (const Surfel& s : map_.surfels()) {
      if (!MayAnswer(s, point, direction)) continue;
      least = std::min(least, std::abs(s.normal.dot(point - s.mean)));
    }
    const int found = map_.Find(point, direction, kGate, kCosine);
    if (found >= 0) {
      const Surfel& s = map_.surfels()[found];
      EXPECT_GE(s.normal.dot(direction), kCosine);
      EXPECT_LE(std::abs(s.normal.dot(point - s.mean)), kGate);
      // Beside the height, nearness along the surface counts up to five centimetres.
      EXPECT_LE(std::abs(s.normal.dot(point - s.mean)), least + 0.05 + 1e-9);
    }
    answers += std::isfinite(least);
    lost += std::isfinite(least) && found < 0;
  }
  EXPECT_GT(answers, 1000);
  EXPECT_LE(lost, answers / 200);
}

TEST_F(PatchMapTest, NothingIsFoundInFreeSpaceOrFromBehind) {
  EXPECT_EQ(map_.Find({0, 0, 0.3}, Eigen::Vector3d::UnitX(), 0.1, kCosine), -1);
  const Surfel& s = map_.surfels()[0];
  EXPECT_EQ(map_.Find(s.mean, -s.normal, 0.05, kCosine), -1);
}

TEST(PatchMap, EmptyMap) {
  const PatchMap map({});
  EXPECT_EQ(map.Find(Eigen::Vector3d::Zero(), Eigen::Vector3d::UnitX(), 1.0, 0.9), -1);
}

TEST(Surfel, HeightVarianceGrowsWithTheDistance) {
  Surfel s;
  s.mean.setZero();
  s.normal = Eigen::Vector3d::UnitZ();
  s.axis1 = Eigen::Vector3d::UnitX();
  s.axis2 = Eigen::Vector3d::UnitY();
  s.variance1 = 1e-4, s.variance2 = 4e-4, s.offset_variance = 1e-6;
  EXPECT_DOUBLE_EQ(s.HeightVariance({0, 0, 5}), 1e-6);
  EXPECT_DOUBLE_EQ(s.HeightVariance({2, 3, 0}), 1e-6 + 4e-4 + 36e-4);
}

}  // namespace
}  // namespace planegraph
