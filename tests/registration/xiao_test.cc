#include "planegraph/registration/xiao.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "planegraph/geometry/rotation.h"
#include "registration/plane_rooms.h"

namespace planegraph {
namespace {

Rigid3 Pose(double x, double y, double yaw) {
  return {ExpSO3(Eigen::Vector3d(0.02, -0.01, yaw)), Eigen::Vector3d(x, y, 0.8)};
}

std::size_t Rejected(const XiaoMatch& match, const std::string& reason) {
  for (const auto& [name, count] : match.rejected) {
    if (name == reason) return count;
  }
  ADD_FAILURE() << "no reason called " << reason;
  return 0;
}

TEST(XiaoTest, FindsThePoseWithoutAGuess) {
  const Rigid3 a = Pose(0, 0, 0), b = Pose(2, 1, 1.9);
  const PlaneSet target = Measure(Hall(), a, 1e-3, 5e-3, 1);
  PlaneSet source = Measure(Hall(), b, 1e-3, 5e-3, 2);
  std::reverse(source.planes.begin(), source.planes.end());
  const Registration result = RegisterXiao(target, source);
  EXPECT_EQ(result.status, RegistrationStatus::kOk) << result.reason;
  const Rigid3 error = result.target_from_source() * (a.Inverse() * b).Inverse();
  EXPECT_LT(error.translation.norm(), 0.03);
  EXPECT_LT(AngleBetween(error.rotation, Eigen::Quaterniond::Identity()), 0.003);
  const auto last = static_cast<std::int32_t>(source.planes.size()) - 1;
  EXPECT_EQ(result.refinement.correspondences.size(), source.planes.size());
  for (const PlanePair& pair : result.refinement.correspondences) {
    EXPECT_EQ(pair.source, last - pair.target);
  }
}

TEST(XiaoTest, TwoDirectionsAreReportedWithTheOpenOne) {
  const Rigid3 b(ExpSO3(Eigen::Vector3d(0, 0, 0.1)), Eigen::Vector3d(0.7, 0.2, 0.0));
  const Registration result =
      RegisterXiao(Measure(Corridor(), {}, 0, 0, 1), Measure(Corridor(), b, 0, 0, 2));
  EXPECT_EQ(result.status, RegistrationStatus::kDegenerate);
  ASSERT_EQ(result.unobserved.size(), 1u);
  EXPECT_NEAR(std::abs(result.unobserved[0].direction[0]), 1.0, 1e-3);
  EXPECT_NEAR(result.target_from_source().translation.y(), 0.2, 0.02);
}

TEST(XiaoTest, SymmetricRoomIsAmbiguous) {
  std::vector<Rectangle> box = Hall();
  box.resize(5);
  // Four equal walls in a square turn into themselves by 90 degrees.
  const Eigen::Vector3d x(1, 0, 0), y(0, 1, 0), z(0, 0, 1);
  box = {{{0, 0, 0}, x, y, 5, 5},
         {{-5, 0, 2}, y, z, 5, 2},
         {{5, 0, 2}, z, y, 2, 5},
         {{0, -5, 2}, z, x, 2, 5},
         {{0, 5, 2}, x, z, 5, 2}};
  const Registration result =
      RegisterXiao(Measure(box, {}, 1e-3, 2e-3, 1), Measure(box, Pose(1, 0, 0.3), 1e-3, 2e-3, 2));
  EXPECT_EQ(result.status, RegistrationStatus::kAmbiguous) << result.reason;
}

TEST(XiaoTest, NothingInCommonFailsWithAReason) {
  const PlaneSet hall = Measure(Hall(), {}, 0, 0, 1);
  const Registration none = RegisterXiao(hall, PlaneSet());
  EXPECT_EQ(none.status, RegistrationStatus::kFailed);
  EXPECT_FALSE(none.reason.empty());
}

TEST(XiaoTest, CapStopsTheSearchAndSaysSo) {
  const PlaneSet hall = Measure(Hall(), {}, 1e-3, 1e-3, 1);
  XiaoOptions options;
  options.most_triplets = 3;
  const XiaoMatch match = MatchXiao(hall, hall, options);
  EXPECT_TRUE(match.capped);
  EXPECT_EQ(match.triplets, 3u);
  EXPECT_NE(match.reason.find("3 triplets"), std::string::npos);
}

TEST(XiaoTest, CountsWhatItRejects) {
  const PlaneSet hall = Measure(Hall(), {}, 1e-3, 1e-3, 1);
  XiaoOptions options;
  const XiaoMatch match = MatchXiao(hall, hall, options);
  EXPECT_GT(Rejected(match, "areas differ"), 0u);
  EXPECT_GT(Rejected(match, "two planes nearly parallel"), 0u);
  EXPECT_EQ(Rejected(match, "translation too long"), 0u);
  options.max_translation = 1e-6;
  const XiaoMatch none = MatchXiao(hall, Measure(Hall(), Pose(2, 1, 0), 0, 0, 2), options);
  EXPECT_TRUE(none.solutions.empty());
  EXPECT_GT(Rejected(none, "translation too long"), 0u);
  EXPECT_FALSE(none.reason.empty());
}

TEST(XiaoTest, UnknownSidesAreTriedBothWays) {
  const Rigid3 b = Pose(1, 0.5, 0.4);
  const PlaneSet target = Measure(Hall(), {}, 1e-3, 2e-3, 1);
  PlaneSet source = Measure(Hall(), b, 1e-3, 2e-3, 2);
  for (std::size_t k = 0; k < source.planes.size(); ++k) {
    PlaneSegment& plane = source.planes[k];
    plane.orientation = Orientation::kUnknown;
    if (k % 2 == 0) plane.plane = plane.plane.Flipped();
  }
  const Registration result = RegisterXiao(target, source);
  const Rigid3 error = result.target_from_source() * b.Inverse();
  EXPECT_LT(error.translation.norm(), 0.03) << result.reason;
}

TEST(OverlapTest, NormalDirectionDoesNotCountAndToleranceDoes) {
  const Eigen::Vector3d x(1, 0, 0), y(0, 1, 0);
  const PlaneBox target{Eigen::Vector3d::Zero(), x, y, 2, 1};
  const PlaneBox source{Eigen::Vector3d::Zero(), y, x, 1, 0.5};
  const Eigen::Matrix3d same = Eigen::Matrix3d::Identity();
  EXPECT_TRUE(BoxesOverlap(target, source, same, {0, 0, 50}, 0.0));
  EXPECT_TRUE(BoxesOverlap(target, source, same, {2.4, 1.9, 0}, 0.0));
  EXPECT_FALSE(BoxesOverlap(target, source, same, {2.6, 0, 0}, 0.0));
  EXPECT_FALSE(BoxesOverlap(target, source, same, {0, 2.1, 0}, 0.0));
  EXPECT_TRUE(BoxesOverlap(target, source, same, {2.6, 0, 0}, 0.2));
}

}  // namespace
}  // namespace planegraph
