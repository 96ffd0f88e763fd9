#include "planegraph/correspondence/scan_group.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "planegraph/correspondence/patch_map.h"
#include "planegraph/segmentation/segmenter.h"
#include "segmentation/ray_world.h"

namespace planegraph {
namespace {

class ScanGroupTest : public testing::Test {
 protected:
  ScanGroupTest() : a_(PlanesAt(0.0, 1)), b_(PlanesAt(1.0, 2)), model_a_(a_), model_b_(b_) {
    group_.scans = {&model_a_, &model_b_};
    group_.group_from_scan = {MakePose(1, 2, 3, 0.5), MakePose(-4, 0, 1, 2.0, 0.1)};
  }
  static PlaneSet PlanesAt(double x, std::uint64_t seed) {
    return SegmentPlanes(
               ScanWorld(FurnishedRoom(3), MakePose(x, 0, 1.3, 0.3), 20000, {}, seed).cloud)
        .planes;
  }

  PlaneSet a_, b_;
  ScanModel model_a_, model_b_;
  ScanGroup group_;
};

TEST_F(ScanGroupTest, OneScanIsAGroup) {
  const ScanGroup group(model_a_);
  ASSERT_EQ(group.scans.size(), 1u);
  EXPECT_EQ(group.group_from_scan[0].translation.norm(), 0.0);
}

TEST_F(ScanGroupTest, WeightsOfEachScanSumToOne) {
  for (const std::size_t most : {1u, 7u, 64u, 256u, 100000u}) {
    std::vector<double> sums(2, 0.0);
    std::vector<std::size_t> counts(2, 0);
    for (const GroupSample& s : SamplesOf(group_, most)) {
      sums[s.scan] += s.weight;
      ++counts[s.scan];
      EXPECT_GT(s.weight, 0.0);
    }
    for (const double sum : sums) EXPECT_NEAR(sum, 1.0, 1e-12) << most;
    for (const std::size_t count : counts) EXPECT_LE(count, most);
  }
}

TEST_F(ScanGroupTest, SamplesAreSurfelsInTheGroupsFrame) {
  for (const GroupSample& s : SamplesOf(group_, 50)) {
    const Surfel& surfel = group_.scans[s.scan]->map.surfels()[s.surfel];
    const Rigid3& pose = group_.group_from_scan[s.scan];
    EXPECT_LT((s.mean - pose * surfel.mean).norm(), 1e-12);
    EXPECT_LT((s.normal - pose.rotation * surfel.normal).norm(), 1e-12);
  }
}

TEST_F(ScanGroupTest, AnEmptyScanHasNoSamples) {
  const PlaneSet nothing;
  const ScanModel empty(nothing);
  for (const std::size_t most : {0u, 1u, 50u}) {
    EXPECT_TRUE(SamplesOf(ScanGroup(empty), most).empty());
  }
  group_.scans.push_back(&empty);
  group_.group_from_scan.push_back(Rigid3());
  for (const GroupSample& s : SamplesOf(group_, 50)) EXPECT_LT(s.scan, 2u);
  EXPECT_TRUE(DirectionsOf(ScanGroup(empty)).empty());
}

TEST_F(ScanGroupTest, DirectionsTurnWithTheGroup) {
  const auto before = DirectionsOf(group_);
  ASSERT_GE(before.size(), 5u) << "a room has six";
  const Rigid3 motion = MakePose(5, -3, 2, 1.0, 0.4, -0.7);
  ScanGroup moved = group_;
  for (Rigid3& pose : moved.group_from_scan) pose = motion * pose;
  const auto after = DirectionsOf(moved);
  ASSERT_EQ(after.size(), before.size());
  for (std::size_t k = 0; k < after.size(); ++k) {
    EXPECT_LT((after[k].direction - motion.rotation * before[k].direction).norm(), 1e-9);
    EXPECT_NEAR(after[k].weight, before[k].weight, 1e-9);
    EXPECT_NEAR(after[k].direction.norm(), 1.0, 1e-12);
    EXPECT_LE(after[k].weight, after[k == 0 ? 0 : k - 1].weight);
  }
}

TEST_F(ScanGroupTest, ASecondLookAddsArea) {
  const auto once = DirectionsOf(ScanGroup(model_a_));
  ScanGroup twice(model_a_);
  twice.scans.push_back(&model_a_);
  twice.group_from_scan.push_back(MakePose(7, 7, 7, 0.0));  // moved, not turned
  const auto both = DirectionsOf(twice);
  ASSERT_EQ(both.size(), once.size());
  for (std::size_t k = 0; k < once.size(); ++k) {
    EXPECT_NEAR(both[k].weight, std::sqrt(2.0) * once[k].weight, 1e-9);
  }
}

ScanGroup Row(const ScanModel& scan, const std::vector<double>& places) {
  ScanGroup group;
  for (const double x : places) {
    group.scans.push_back(&scan);
    group.group_from_scan.push_back(MakePose(x, 0, 0, x));
  }
  return group;
}

TEST_F(ScanGroupTest, AroundIsWhatStandsNear) {
  const ScanGroup row = Row(model_a_, {0, 4, 8, 12, 40});
  const ScanGroup around = Around(row, 2, 5.0);
  ASSERT_EQ(around.scans.size(), 3u);
  const Rigid3 anchor_from_group = row.group_from_scan[2].Inverse();
  for (std::size_t k = 0; k < 3; ++k) {
    const Rigid3 expected = anchor_from_group * row.group_from_scan[k + 1];
    EXPECT_LT((around.group_from_scan[k].translation - expected.translation).norm(), 1e-12);
    EXPECT_LT(AngleBetween(around.group_from_scan[k].rotation, expected.rotation), 1e-7);
  }
  EXPECT_EQ(Around(row, 4, 5.0).scans.size(), 1u);
  EXPECT_EQ(Around(row, 4, 0.0).scans.size(), 1u) << "the anchor itself stays";
}

TEST_F(ScanGroupTest, AnchorsAreFarApart) {
  const ScanGroup row = Row(model_a_, {0, 4, 8, 12, 16, 20, 24, 28, 32, 36, 40});
  const auto anchors = Anchors(row, 12.0, 4);
  EXPECT_EQ(anchors, (std::vector<std::size_t>{0, 10, 5}));  // then none is more than 12 m away
  EXPECT_EQ(Anchors(row, 1.0, 4).size(), 4u);
  const auto all = Anchors(row, 1.0, 100);
  EXPECT_EQ(std::set<std::size_t>(all.begin(), all.end()).size(), row.scans.size());
  EXPECT_EQ(Anchors(row, 1000.0, 4), (std::vector<std::size_t>{0}));
}

TEST_F(ScanGroupTest, APatchThatMayFaceEitherWayIsTwoSurfels) {
  PlaneSet set = a_;
  for (std::size_t i = 0; i < set.patches.size(); i += 3) {
    set.patches[i].orientation = Orientation::kUnknown;
  }
  const auto surfels = MakeSurfels(set);
  const std::size_t unknown = (set.patches.size() + 2) / 3;
  ASSERT_EQ(surfels.size(), set.patches.size() + unknown);
  const PatchMap map(surfels);
  std::size_t next = 0;
  for (std::size_t i = 0; i < set.patches.size(); ++i, ++next) {
    const Surfel& front = surfels[next];
    EXPECT_EQ(front.mean, set.patches[i].moments.mean);
    if (i % 3 != 0) continue;
    const Surfel& back = surfels[++next];
    EXPECT_EQ(back.mean, front.mean);
    EXPECT_EQ(back.normal, -front.normal);
    EXPECT_EQ(back.HeightVariance({1, 2, 3}), front.HeightVariance({1, 2, 3}));
    EXPECT_GE(map.Find(front.mean, front.normal, 0.05, 0.95), 0);
    EXPECT_GE(map.Find(back.mean, back.normal, 0.05, 0.95), 0);
  }
}

}  // namespace
}  // namespace planegraph
