#include "planegraph/correspondence/map_hypotheses.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <random>

#include "planegraph/segmentation/map_segmenter.h"
#include "segmentation/vision_world.h"

namespace planegraph {
namespace {

// A map of the village and scans in it.
class VillageTest : public testing::Test {
 protected:
  static PlaneSet MapOf(const RayWorld& world, const Sim3& map_from_world) {
    Cloud cloud = SampleFaces(world, {}, 1);
    const Eigen::Matrix3f turn = map_from_world.rotation.toRotationMatrix().cast<float>();
    for (auto& p : cloud.points)
      p = (map_from_world * Eigen::Vector3d(p.cast<double>())).cast<float>();
    for (auto& n : cloud.normals) n = turn * n;
    MapSegmentationOptions options;
    options.segmentation = VisionOptions(cloud);
    options.threads = 2;
    return SegmentMap(cloud, options).planes;
  }
  static PlaneSet ScanAt(const Rigid3& world_from_scan, std::uint64_t seed) {
    return SegmentPlanes(ScanWorld(village(), world_from_scan, 20000, {0.005, 0.0}, seed).cloud)
        .planes;
  }
  static const RayWorld& village() {
    static const RayWorld world = Village();
    return world;
  }
  static const PlaneSet& map_planes() {
    static const PlaneSet planes = MapOf(village(), Sim3());
    return planes;
  }
  static const MapModel& map() {
    static const MapModel model(map_planes());
    return model;
  }
};

double DegreesOff(const Sim3& found, const Sim3& truth) {
  return AngleBetween(found.rotation, truth.rotation) * 180.0 / std::numbers::pi;
}

// Whether some hypothesis is so near that refinement takes over.
int RankOf(const std::vector<MapHypothesis>& found, const Sim3& truth, double metres = 1.6,
           double degrees = 6.0) {
  for (std::size_t k = 0; k < found.size(); ++k) {
    const Sim3& pose = found[k].map_from_group;
    if ((pose.translation - truth.translation).norm() < metres &&
        DegreesOff(pose, truth) < degrees) {
      return static_cast<int>(k);
    }
  }
  return -1;
}

// Places of the village that are free, and any heading.
std::vector<Rigid3> RandomPoses(int count) {
  const Eigen::Vector2d places[] = {{0, 0}, {-3, -2}, {0.5, 8}, {14, -1}, {-14, 2}, {12, 12}};
  std::mt19937_64 engine(5);
  std::uniform_real_distribution<double> uniform(-1.0, 1.0);
  std::vector<Rigid3> poses;
  for (int k = 0; k < count; ++k) {
    const double yaw = std::numbers::pi * uniform(engine);
    const double roll = 0.05 * uniform(engine), pitch = 0.05 * uniform(engine);
    poses.push_back(MakePose(places[k % 6].x(), places[k % 6].y(), 1.3, yaw, roll, pitch));
  }
  return poses;
}

TEST_F(VillageTest, TheTruthIsAmongTheHypotheses) {
  for (const bool upright : {false, true}) {
    int seed = 0;
    for (const Rigid3& pose : RandomPoses(6)) {
      const PlaneSet planes = ScanAt(pose, ++seed);
      const ScanModel scan(planes);
      MapPrior prior;
      prior.upright = upright;
      const auto found = FindMapHypotheses(map(), ScanGroup(scan), prior, 400, 2);
      EXPECT_LE(found.size(), 400u);
      const int rank = RankOf(found, Sim3(pose));
      EXPECT_GE(rank, 0) << pose.translation.transpose();
      EXPECT_LT(rank, 100) << pose.translation.transpose();
    }
  }
}

TEST_F(VillageTest, MostVotesFirstAndNoMoreThanVoters) {
  const PlaneSet planes = ScanAt(MakePose(0, 0, 1.3, 0.4), 1);
  const ScanModel scan(planes);
  const auto found = FindMapHypotheses(map(), ScanGroup(scan), {}, 50);
  ASSERT_EQ(found.size(), 50u);
  for (std::size_t k = 0; k < found.size(); ++k) {
    EXPECT_LE(found[k].votes, static_cast<int>(kMapVoters));
    EXPECT_LE(found[k].votes, found[k == 0 ? 0 : k - 1].votes);
  }
}

TEST_F(VillageTest, EqualForAnyNumberOfThreads) {
  const PlaneSet planes = ScanAt(MakePose(0, 0, 1.3, 0.4), 1);
  const ScanModel scan(planes);
  const auto one = FindMapHypotheses(map(), ScanGroup(scan), {}, 60, 1);
  const auto three = FindMapHypotheses(map(), ScanGroup(scan), {}, 60, 3);
  ASSERT_EQ(one.size(), three.size());
  for (std::size_t k = 0; k < one.size(); ++k) {
    EXPECT_EQ(one[k].map_from_group.translation, three[k].map_from_group.translation);
    EXPECT_EQ(one[k].map_from_group.rotation.coeffs(), three[k].map_from_group.rotation.coeffs());
    EXPECT_EQ(one[k].votes, three[k].votes);
  }
}

TEST_F(VillageTest, AMapInAnyAttitude) {
  const Sim3 map_from_world(1.0, ExpSO3({0.6, -1.0, 0.8}), {30, -20, 10});
  const PlaneSet turned = MapOf(village(), map_from_world);
  const MapModel model(turned);
  const Rigid3 pose = MakePose(0, 0, 1.3, 0.4);
  const PlaneSet planes = ScanAt(pose, 1);
  const ScanModel scan(planes);
  const auto found = FindMapHypotheses(model, ScanGroup(scan), {}, 400, 2);
  EXPECT_GE(RankOf(found, map_from_world * Sim3(pose)), 0);
}

TEST_F(VillageTest, ScalesAreTriedAsFarAsTheirSigmaGoes) {
  const PlaneSet planes = ScanAt(MakePose(0, 0, 1.3, 0.4), 1);
  const ScanModel scan(planes);
  const double all = 1e6;
  for (const double sigma : {0.001, 0.02, 0.05, 0.25}) {
    MapPrior prior;
    prior.sigma_scale = sigma;
    prior.pose = MapPrior::Pose{MakePose(0, 0, 1.3, 0.4), 1.0, 0.1};
    double low = INFINITY, high = 0.0;
    for (const auto& h :
         FindMapHypotheses(map(), ScanGroup(scan), prior, static_cast<std::size_t>(all))) {
      low = std::min(low, h.map_from_group.scale);
      high = std::max(high, h.map_from_group.scale);
    }
    // Three standard deviations, two of a scale that is hardly known, in steps of at most 5 %.
    const double reach = (sigma > 0.1 ? 2.0 : 3.0) * sigma;
    EXPECT_NEAR(std::log(high), reach, 0.05) << sigma;
    EXPECT_NEAR(std::log(low), -reach, 0.05) << sigma;
  }
}

TEST_F(VillageTest, AScaleThatIsOffIsFoundWithinItsSigma) {
  const double scale = 1.15;  // the map's unit is 1 / 1.15 m
  const PlaneSet stretched =
      MapOf(village(), Sim3(scale, Eigen::Quaterniond::Identity(), {0, 0, 0}));
  const MapModel model(stretched);
  const Rigid3 pose = MakePose(0, 0, 1.3, 0.4);
  const PlaneSet planes = ScanAt(pose, 1);
  const ScanModel scan(planes);
  MapPrior prior;
  prior.sigma_scale = 0.1;
  const auto found = FindMapHypotheses(model, ScanGroup(scan), prior, 400, 2);
  const Sim3 truth(scale, pose.rotation, scale * pose.translation);
  ASSERT_GE(RankOf(found, truth), 0);
}

TEST_F(VillageTest, UprightMeansUpright) {
  const PlaneSet planes = ScanAt(MakePose(0, 0, 1.3, 0.4), 1);
  const ScanModel scan(planes);
  MapPrior prior;
  prior.upright = true;
  prior.most_tilt = 0.2;
  for (const auto& h : FindMapHypotheses(map(), ScanGroup(scan), prior, 400, 2)) {
    const Eigen::Vector3d up = h.map_from_group.rotation * Eigen::Vector3d::UnitZ();
    EXPECT_LE(std::acos(std::min(1.0, up.z())), 0.2 + 1e-9);
  }
}

TEST_F(VillageTest, APriorOfThePoseBoundsWhatIsTried) {
  const Rigid3 pose = MakePose(0, 0, 1.3, 0.4);
  const PlaneSet planes = ScanAt(pose, 1);
  const ScanModel scan(planes);
  MapPrior prior;
  const Rigid3 guess(ExpSO3({0.0, 0.0, 0.1}) * pose.rotation,
                     pose.translation + Eigen::Vector3d(0.8, -0.6, 0.2));
  prior.pose = MapPrior::Pose{guess, 0.7, 0.1};
  const auto found = FindMapHypotheses(map(), ScanGroup(scan), prior, 400, 2);
  EXPECT_GE(RankOf(found, Sim3(pose)), 0);
  EXPECT_LT(RankOf(found, Sim3(pose)), 20);
  const double reach = 3.0 * 0.7 + 2.0 * 0.8;  // three sigmas, and voxels
  const double turn = std::sqrt(3.0) * 3.0 * 0.1 + 2.0 * std::numbers::pi / 180.0;
  for (const auto& h : found) {
    const Eigen::Vector3d off = h.map_from_group.translation - guess.translation;
    EXPECT_LE(off.cwiseAbs().maxCoeff(), reach);
    EXPECT_LE(AngleBetween(h.map_from_group.rotation, guess.rotation), turn + 1e-9);
  }
}

TEST_F(VillageTest, AGroupVotesAsOne) {
  const Rigid3 first = MakePose(0, 0, 1.3, 0.4), second = MakePose(-3, -2, 1.3, 2.0);
  const PlaneSet a = ScanAt(first, 1), b = ScanAt(second, 2);
  const ScanModel scan_a(a), scan_b(b);
  ScanGroup group(scan_a);
  group.scans.push_back(&scan_b);
  group.group_from_scan.push_back(first.Inverse() * second);
  const auto found = FindMapHypotheses(map(), group, {}, 400, 2);
  EXPECT_GE(RankOf(found, Sim3(first)), 0);
}

TEST_F(VillageTest, NothingInNothing) {
  const PlaneSet nothing;
  const MapModel empty_map(nothing);
  const ScanModel empty_scan(nothing);
  const PlaneSet planes = ScanAt(MakePose(0, 0, 1.3, 0.4), 1);
  const ScanModel scan(planes);
  EXPECT_TRUE(FindMapHypotheses(empty_map, ScanGroup(scan), {}, 10).empty());
  EXPECT_TRUE(FindMapHypotheses(map(), ScanGroup(empty_scan), {}, 10).empty());
  EXPECT_TRUE(FindMapHypotheses(empty_map, ScanGroup(empty_scan), {}, 10).empty());
}

TEST_F(VillageTest, ASectionIsWhatLiesWithinItsRadius) {
  const Eigen::Vector3d centre(9, 5, 2);
  const auto section = map().Section(centre, 6.0);
  EXPECT_FALSE(section.empty());
  std::size_t inside = 0;
  for (const Surfel& s : map().surfaces().surfels()) inside += (s.mean - centre).norm() <= 6.0;
  EXPECT_EQ(section.size(), inside);
  for (const auto i : section) {
    EXPECT_LE((map().surfaces().surfels()[i].mean - centre).norm(), 6.0);
  }
  EXPECT_TRUE(map().Section({1000, 0, 0}, 5.0).empty());
}

}  // namespace
}  // namespace planegraph
