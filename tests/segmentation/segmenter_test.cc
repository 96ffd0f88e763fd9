#include "planegraph/segmentation/segmenter.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <random>

#include "segmentation/ray_world.h"

namespace planegraph {
namespace {

// Errors of a plane in the coordinates of its covariance: tilt about both axes, offset at the
// centroid.
Eigen::Vector3d PlaneError(const PlaneSegment& found, const Plane& truth) {
  const Eigen::Vector3d difference = truth.normal - found.plane.normal;
  return {found.axes.vectors.col(1).dot(difference), found.axes.vectors.col(2).dot(difference),
          truth.distance - truth.normal.dot(found.centroid())};
}

double Nees(const PlaneSegment& found, const Plane& truth) {
  const Eigen::Vector3d e = PlaneError(found, truth);
  return e.dot(found.covariance.inverse() * e);
}

std::map<int, int> CountLabels(const std::vector<int>& labels) {
  std::map<int, int> counts;
  for (const int label : labels) counts[label]++;
  return counts;
}

// The segment that most points of a face went to, and the intersection over union of both.
struct Match {
  std::int32_t segment = -1;
  double overlap = 0.0;
};
Match MatchFace(const RayScan& scan, const Segmentation& result, int face) {
  std::map<std::int32_t, int> common, total;
  int size = 0;
  for (std::size_t i = 0; i < scan.labels.size(); ++i) {
    if (result.labels[i] >= 0) total[result.labels[i]]++;
    if (scan.labels[i] != face) continue;
    ++size;
    if (result.labels[i] >= 0) common[result.labels[i]]++;
  }
  Match best;
  for (const auto& [segment, count] : common) {
    const double overlap = static_cast<double>(count) / (size + total[segment] - count);
    if (overlap > best.overlap) best = {segment, overlap};
  }
  return best;
}

TEST(SegmentPlanes, FindsTheSixFacesOfARoom) {
  const Rigid3 pose = MakePose(0.8, -0.5, 1.3, 0.7, 0.05, -0.03);
  const RayWorld room = EmptyRoom({7, 5, 3});
  const RayScan scan = ScanWorld(room, pose, 40000, {0.005, 0.0}, 1);
  const Segmentation result = SegmentPlanes(scan.cloud);
  ASSERT_EQ(result.planes.planes.size(), 6u);
  for (int face = 0; face < 6; ++face) {
    const Match match = MatchFace(scan, result, face);
    ASSERT_GE(match.segment, 0);
    EXPECT_GT(match.overlap, 0.95) << face;
    const PlaneSegment& found = result.planes.planes[match.segment];
    const Plane truth = Transform(pose.Inverse(), room.faces[face].plane());
    const Eigen::Vector3d error = PlaneError(found, truth);
    for (int k = 0; k < 3; ++k) {
      EXPECT_LE(std::abs(error[k]), 3.0 * std::sqrt(found.covariance(k, k))) << face << " " << k;
    }
    const double area = 4.0 * room.faces[face].half_u * room.faces[face].half_v;
    EXPECT_NEAR(found.area / area, 1.0, 0.15) << face;
    EXPECT_GT(found.plane.normal.dot(-found.centroid()), 0.0) << "towards the scanner";
  }
}

TEST(SegmentPlanes, LabelsFurnishedRooms) {
  int planes = 0, good = 0, matched_area = 0;
  for (std::uint64_t seed = 0; seed < 4; ++seed) {
    const RayScan scan =
        ScanWorld(FurnishedRoom(seed), MakePose(0.3, 0.2, 1.4, 0.3), 60000, {0.005, 0.0}, seed);
    const Segmentation result = SegmentPlanes(scan.cloud);
    for (const auto& [face, count] : CountLabels(scan.labels)) {
      if (count < 300) continue;
      ++planes;
      good += MatchFace(scan, result, face).overlap >= 0.5;
      matched_area += MatchFace(scan, result, face).overlap >= 0.85;
    }
    EXPECT_LE(result.planes.planes.size(), 1.3 * CountLabels(scan.labels).size());
  }
  EXPECT_GE(good, 0.9 * planes) << planes;
  EXPECT_GE(matched_area, 0.7 * planes) << planes;
}

TEST(SegmentPlanes, TheOrderOfThePointsDoesNotMatter) {
  const RayScan scan = ScanWorld(FurnishedRoom(2), MakePose(0, 0, 1.4, 0), 20000, {}, 4);
  std::vector<std::uint32_t> order(scan.cloud.size());
  for (std::uint32_t i = 0; i < order.size(); ++i) order[i] = i;
  std::mt19937_64 engine(9);
  std::shuffle(order.begin(), order.end(), engine);
  const Segmentation a = SegmentPlanes(scan.cloud);
  const Segmentation b = SegmentPlanes(Select(scan.cloud, order));
  ASSERT_EQ(a.planes.planes.size(), b.planes.planes.size());
  for (std::size_t p = 0; p < a.planes.planes.size(); ++p) {
    EXPECT_LT((a.planes.planes[p].plane.normal - b.planes.planes[p].plane.normal).norm(), 1e-6);
    EXPECT_NEAR(a.planes.planes[p].plane.distance, b.planes.planes[p].plane.distance, 1e-6);
  }
  int different = 0;
  for (std::size_t i = 0; i < order.size(); ++i) different += b.labels[i] != a.labels[order[i]];
  EXPECT_LE(different, static_cast<int>(order.size()) / 1000);
}

TEST(SegmentPlanes, PlanesMoveWithTheCloud) {
  const RayScan scan = ScanWorld(EmptyRoom({7, 5, 3}), MakePose(0, 0, 1.3, 0), 30000, {}, 6);
  const Rigid3 motion = MakePose(3.0, -2.0, 0.5, 1.1, 0.2, -0.3);
  Cloud moved = scan.cloud;
  for (auto& point : moved.points) point = (motion * point.cast<double>()).cast<float>();
  moved.viewpoint = motion.translation;
  const Segmentation a = SegmentPlanes(scan.cloud), b = SegmentPlanes(moved);
  ASSERT_EQ(a.planes.planes.size(), b.planes.planes.size());
  for (int face = 0; face < 6; ++face) {
    const PlaneSegment& before = a.planes.planes[MatchFace(scan, a, face).segment];
    const PlaneSegment& after = b.planes.planes[MatchFace(scan, b, face).segment];
    // Another grid takes other points into account: the noise of the plane remains.
    EXPECT_LT(Nees(after, Transform(motion, before.plane)), 16.3) << face;
    EXPECT_NEAR(after.area / before.area, 1.0, 0.1);
  }
}

TEST(SegmentPlanes, TheCovarianceIsThatOfTheErrors) {
  SegmentationOptions options;
  options.noise = NoiseModel{0.01, 0.0};
  options.floor_offset = options.floor_tilt_deg = 0.0;
  options.correlation_length = 1e-4;  // white noise: all points count
  RayWorld world;
  world.AddFace({4, 0, 0}, -Eigen::Vector3d::UnitX(), 1.0, 0.7);
  constexpr int kRuns = 100;
  double sum = 0.0;
  for (int run = 0; run < kRuns; ++run) {
    const RayScan scan = ScanWorld(world, Rigid3(), 60000, {0.01, 0.0}, run);
    const Segmentation result = SegmentPlanes(scan.cloud, options);
    ASSERT_EQ(result.planes.planes.size(), 1u) << run;
    sum += Nees(result.planes.planes[0], world.faces[0].plane());
  }
  // 95 % of chi-square with 3 * 100 degrees of freedom.
  EXPECT_GT(sum, 253.9);
  EXPECT_LT(sum, 349.9);
}

TEST(SegmentPlanes, OneScanLineIsNoPlane) {
  Cloud cloud;
  for (int i = 0; i < 2000; ++i) {
    const double angle = 0.001 * i - 1.0;
    const double range = 5.0 / std::cos(angle);
    cloud.points.push_back(
        Eigen::Vector3d(range * std::cos(angle), range * std::sin(angle), 0.0).cast<float>());
  }
  EXPECT_TRUE(SegmentPlanes(cloud).planes.planes.empty());
}

TEST(SegmentPlanes, CloudsWithoutAPlane) {
  Cloud identical, collinear, tiny;
  for (int i = 0; i < 5000; ++i) {
    identical.points.push_back({1, 2, 3});
    collinear.points.push_back({0.01f * static_cast<float>(i), 1, 2});
  }
  tiny.points = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  for (const Cloud& cloud : {Cloud(), tiny, identical, collinear}) {
    for (const CloudKind kind : {CloudKind::kLaser, CloudKind::kVision}) {
      SegmentationOptions options;
      options.kind = kind;
      const Segmentation result = SegmentPlanes(cloud, options);
      EXPECT_TRUE(result.planes.planes.empty());
      EXPECT_EQ(result.labels, std::vector<std::int32_t>(cloud.size(), -1));
      EXPECT_EQ(result.planes.point_count, cloud.size());
    }
  }
}

TEST(SegmentPlanes, ALargeOffsetChangesNothing) {
  RayScan scan = ScanWorld(EmptyRoom({7, 5, 3}), MakePose(0, 0, 1.3, 0), 20000, {}, 6);
  const Segmentation near = SegmentPlanes(scan.cloud);
  scan.cloud.offset = scan.cloud.viewpoint = Eigen::Vector3d(4e5, 5.7e6, 120.0);
  const Segmentation far = SegmentPlanes(scan.cloud);
  EXPECT_EQ(near.labels, far.labels);
  EXPECT_EQ(far.planes.offset, scan.cloud.offset);
}

}  // namespace
}  // namespace planegraph
