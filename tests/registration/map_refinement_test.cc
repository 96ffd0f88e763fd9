#include "planegraph/registration/map_refinement.h"

#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <cmath>
#include <random>

#include "registration/village_map.h"

namespace planegraph {
namespace {

const Rigid3 kPose = MakePose(0, 0, 1.3, 0.4, 0.02, -0.01);

// Difference of two similarities in the order of the covariance.
Vector7d Difference(const Sim3& found, const Sim3& truth) {
  Vector7d error;
  error << found.translation - truth.translation,
      LogSO3(found.rotation * truth.rotation.conjugate()), std::log(found.scale / truth.scale);
  return error;
}

Sim3 Moved(const Sim3& pose, double metres, double radians, double log_scale,
           const Eigen::Vector3d& direction) {
  const Eigen::Vector3d d = direction.normalized();
  return {pose.scale * std::exp(log_scale), ExpSO3(radians * d) * pose.rotation,
          pose.translation + metres * Eigen::Vector3d(d.y(), d.z(), d.x())};
}

TEST(RefineInMap, ConvergesToTheTruthFromNearIt) {
  const VillageMap village;
  const MadeScan scan(Village(), kPose, 1);
  const double three_degrees = 3.0 * std::numbers::pi / 180.0;
  for (const Eigen::Vector3d& direction :
       {Eigen::Vector3d(1, 0.3, -0.2), Eigen::Vector3d(-0.5, 1, 0.4),
        Eigen::Vector3d(0.1, -0.2, 1)}) {
    for (const double log_scale : {-0.02, 0.02}) {
      const Sim3 start = Moved(Sim3(kPose), 0.5, three_degrees, log_scale, direction);
      const MapRefinement found = RefineInMap(village.model(), ScanGroup(scan.model()), start);
      EXPECT_TRUE(found.converged);
      const Vector7d error = Difference(found.map_from_group, Sim3(kPose));
      EXPECT_LT(error.head<3>().norm(), 0.02);
      EXPECT_LT(error.segment<3>(3).norm(), 0.003);
      EXPECT_LT(std::abs(error[6]), 0.002);
      EXPECT_GT(found.residuals.size(), 100u);
    }
  }
}

TEST(RefineInMap, TheRestDoesNotDependOnTheStart) {
  const VillageMap village;
  const MadeScan scan(Village(), kPose, 1);
  const MapRefinement at_rest = RefineInMap(village.model(), ScanGroup(scan.model()), Sim3(kPose));
  const MapRefinement again =
      RefineInMap(village.model(), ScanGroup(scan.model()), at_rest.map_from_group);
  EXPECT_LT(Difference(again.map_from_group, at_rest.map_from_group).norm(), 1e-3);
}

TEST(RefineInMap, CovarianceIsThatOfAGoodMeasurement) {
  const VillageMap village;
  const MadeScan scan(Village(), kPose, 1);
  const MapRefinement found = RefineInMap(village.model(), ScanGroup(scan.model()), Sim3(kPose));
  const Eigen::SelfAdjointEigenSolver<Matrix7d> solver(found.covariance);
  EXPECT_GT(solver.eigenvalues().minCoeff(), 0.0);
  EXPECT_LT((found.covariance - found.covariance.transpose()).norm(),
            1e-9 * found.covariance.norm());
  for (int k = 0; k < 3; ++k) {
    EXPECT_LT(std::sqrt(found.covariance(k, k)), 0.05);
    EXPECT_LT(std::sqrt(found.covariance(3 + k, 3 + k)), 0.01);
  }
  EXPECT_LT(std::sqrt(found.covariance(6, 6)), 0.02) << "less than its prior";
}

TEST(RefineInMap, ErrorsAreWithinTheCovariance) {
  // The maps' noise is white here, which the covariance must not take for less than it is.
  double worst = 0.0, sum = 0.0;
  constexpr int kRuns = 8;
  for (int run = 0; run < kRuns; ++run) {
    const VillageMap village(Village(), Sim3(), {.sigma = 0.03}, 100 + run);
    const MadeScan scan(Village(), kPose, 200 + run);
    const MapRefinement found = RefineInMap(village.model(), ScanGroup(scan.model()), Sim3(kPose));
    const Vector7d error = Difference(found.map_from_group, Sim3(kPose));
    const double nees = error.dot(found.covariance.ldlt().solve(error));
    worst = std::max(worst, nees);
    sum += nees;
  }
  EXPECT_LT(worst, 24.3) << "99.9 % of chi-square with 7 degrees of freedom";
  EXPECT_LT(sum / kRuns, 11.3) << "99.9 % of the mean of eight";
}

TEST(RefineInMap, AHeldScaleHasNoVarianceOfItsOwn) {
  const VillageMap village;
  const MadeScan scan(Village(), kPose, 1);
  MapRefinementOptions options;
  options.sigma_scale = 0.0;
  const MapRefinement found =
      RefineInMap(village.model(), ScanGroup(scan.model()), Sim3(kPose), options);
  EXPECT_NEAR(found.map_from_group.scale, 1.0, 1e-7);
  EXPECT_LT(std::sqrt(found.covariance(6, 6)), 1e-5);
  EXPECT_LT(Difference(found.map_from_group, Sim3(kPose)).head<3>().norm(), 0.02);
}

TEST(RefineInMap, AMapOfAnotherScaleIsMeasured) {
  for (const double scale : {0.97, 1.03}) {
    const Sim3 map_from_world(scale, Eigen::Quaterniond::Identity(), {0, 0, 0});
    const VillageMap village(Village(), map_from_world);
    const MadeScan scan(Village(), kPose, 1);
    const Sim3 truth = map_from_world * Sim3(kPose);
    MapRefinementOptions options;
    options.sigma_scale = 0.05;
    const MapRefinement found =
        RefineInMap(village.model(), ScanGroup(scan.model()), Sim3(kPose), options);
    EXPECT_NEAR(found.map_from_group.scale / scale, 1.0, 0.003);
    EXPECT_LT((found.map_from_group.translation - truth.translation).norm(), 0.03);
  }
}

TEST(RefineInMap, MovesWithTheMap) {
  // Patches in another frame, not another segmentation: the result moves exactly.
  const VillageMap village;
  const Rigid3 motion(ExpSO3({0.4, -0.8, 2.0}), {40, -7, 12});
  PlaneSet moved = village.planes();
  for (Patch& patch : moved.patches) {
    patch.moments = Transform(motion, patch.moments);
    patch.normal = motion.rotation * patch.normal;
    patch.segment = -1;
  }
  PlaneSet unmoved = village.planes();
  for (Patch& patch : unmoved.patches) patch.segment = -1;
  const MapModel there(moved), here(unmoved);
  const MadeScan scan(Village(), kPose, 1);
  const Sim3 start = Moved(Sim3(kPose), 0.3, 0.02, 0.01, {1, 2, 3});
  const MapRefinement a = RefineInMap(here, ScanGroup(scan.model()), start);
  const MapRefinement b = RefineInMap(there, ScanGroup(scan.model()), Sim3(motion) * start);
  const Vector7d off = Difference(b.map_from_group, Sim3(motion) * a.map_from_group);
  EXPECT_LT(off.head<3>().norm(), 2e-3);
  EXPECT_LT(off.segment<3>(3).norm(), 2e-4);
  EXPECT_LT(std::abs(off[6]), 2e-4);
}

TEST(RefineInMap, TheFrameOfTheGroupDoesNotMatter) {
  const VillageMap village;
  const MadeScan scan(Village(), kPose, 1);
  ScanGroup group(scan.model());
  const Sim3 start = Moved(Sim3(kPose), 0.3, 0.02, 0.0, {1, 2, 3});
  const MapRefinement a = RefineInMap(village.model(), group, start);
  const Rigid3 shift = MakePose(5, -4, 2, 1.0, 0.3, 0.2);
  group.group_from_scan[0] = shift;
  const MapRefinement b = RefineInMap(village.model(), group, start * Sim3(shift.Inverse()));
  const Vector7d off = Difference(b.map_from_group * Sim3(shift), a.map_from_group);
  EXPECT_LT(off.norm(), 2e-3);
}

// A hall whose roof is 0.1 m thick: a scanner inside sees the underside, a drone the top.
RayWorld HallInside() {
  RayWorld world;
  world.AddFace({0, 0, 0}, Eigen::Vector3d::UnitZ(), 8.0, 10.0);
  world.AddFace({0, 0, 4.0}, -Eigen::Vector3d::UnitZ(), 8.0, 10.0);
  world.AddFace({9.9, 0, 2}, -Eigen::Vector3d::UnitX(), 7.9, 2.0);
  world.AddFace({0, 7.9, 2}, -Eigen::Vector3d::UnitY(), 9.9, 2.0);
  world.AddFace({3, 2, 1}, -Eigen::Vector3d::UnitX(), 2.0, 1.0);
  world.AddFace({2, -3, 1}, Eigen::Vector3d::UnitY(), 2.0, 1.0);
  return world;
}
RayWorld HallFromAbove() {
  RayWorld world = HallInside();
  world.faces.erase(world.faces.begin() + 1);
  world.AddFace({0, 0, 4.1}, Eigen::Vector3d::UnitZ(), 8.0, 10.0);
  return world;
}

TEST(RefineInMap, ARoofsUndersideIsNotItsTop) {
  const Rigid3 pose = MakePose(-1, 0, 1.3, 0.2);
  const VillageMap map(HallFromAbove());
  const MadeScan scan(HallInside(), pose, 1);
  const MapRefinement found = RefineInMap(map.model(), ScanGroup(scan.model()), Sim3(pose));
  EXPECT_LT((found.map_from_group.translation - pose.translation).norm(), 0.02);
  EXPECT_NEAR(found.map_from_group.scale, 1.0, 0.005) << "not stretched up to the top";
  for (const MapResidual& r : found.residuals) EXPECT_LT(r.place.z(), 3.9);
}

TEST(RefineInMap, WithoutSurfacesThePoseStays) {
  const PlaneSet nothing;
  const MapModel empty_map(nothing);
  const ScanModel empty_scan(nothing);
  const VillageMap village;
  const MadeScan scan(Village(), kPose, 1);
  const std::pair<const MapModel*, const ScanModel*> pairs[] = {{&empty_map, &scan.model()},
                                                                {&village.model(), &empty_scan}};
  for (const auto& [map, model] : pairs) {
    const MapRefinement found = RefineInMap(*map, ScanGroup(*model), Sim3(kPose));
    EXPECT_LT(Difference(found.map_from_group, Sim3(kPose)).norm(), 1e-9);
    EXPECT_TRUE(found.residuals.empty());
    EXPECT_TRUE(found.covariance.allFinite());
    EXPECT_GT(std::sqrt(found.covariance(0, 0)), 100.0) << "nothing is known";
  }
}

// Residuals of surfaces in 60 blocks, with a white error and one that each block has in common.
std::vector<MapResidual> MakeResiduals(double white, double common, int in_block,
                                       std::uint64_t seed) {
  std::mt19937_64 engine(seed);
  std::normal_distribution<double> normal;
  std::vector<MapResidual> residuals;
  for (int b = 0; b < 60; ++b) {
    const double shared = common * normal(engine);
    for (int k = 0; k < in_block; ++k) {
      MapResidual r{};
      r.place = MapErrors::kBlock * Eigen::Vector3d(b % 10 + 0.5, b / 10 + 0.5, 0.5);
      r.normal = Eigen::Vector3d::UnitZ();
      r.height = shared + white * normal(engine);
      r.variance = 1e-4;
      residuals.push_back(r);
    }
  }
  return residuals;
}

TEST(MeasureMapErrors, KnownErrorsAreMeasured) {
  for (const double common : {0.02, 0.05}) {
    for (const double white : {0.02, 0.04}) {
      double sigma = 0.0, block = 0.0;
      constexpr int kRuns = 20, kInBlock = 25;
      for (int run = 0; run < kRuns; ++run) {
        const MapErrors found = MeasureMapErrors(MakeResiduals(white, common, kInBlock, run));
        sigma += found.sigma / kRuns;
        block += found.block_sigma / kRuns;
      }
      EXPECT_NEAR(sigma / std::hypot(white, common), 1.0, 0.1) << white << " " << common;
      // The mean of a block keeps the common error and the white one over the root of its number.
      const double expected = std::hypot(common, white / std::sqrt(1.0 * kInBlock));
      EXPECT_NEAR(block / expected, 1.0, 0.15) << white << " " << common;
    }
  }
}

TEST(MeasureMapErrors, OutliersDoNotCount) {
  auto residuals = MakeResiduals(0.03, 0.01, 25, 1);
  const MapErrors before = MeasureMapErrors(residuals);
  for (std::size_t i = 0; i < residuals.size(); i += 20) residuals[i].height = 0.8;
  const MapErrors after = MeasureMapErrors(residuals);
  EXPECT_NEAR(after.sigma / before.sigma, 1.0, 0.15);
  EXPECT_NEAR(after.block_sigma / before.block_sigma, 1.0, 0.2);
}

TEST(MeasureMapErrors, FewResidualsLeaveTheDefaults) {
  const MapErrors defaults;
  for (const std::size_t count : {0u, 1u, 29u}) {
    auto few = MakeResiduals(0.2, 0.1, 1, 2);
    few.resize(count);
    const MapErrors found = MeasureMapErrors(few);
    EXPECT_EQ(found.sigma, defaults.sigma);
    EXPECT_EQ(found.block_sigma, defaults.block_sigma);
  }
}

TEST(MapBlock, TellsPlacesAndSidesApart) {
  const Eigen::Vector3d place(1, 2, 3), x = Eigen::Vector3d::UnitX(), z = Eigen::Vector3d::UnitZ();
  EXPECT_EQ(MapBlock(place, z), MapBlock(place + Eigen::Vector3d(2, 2, 2), z));
  EXPECT_NE(MapBlock(place, z), MapBlock(place, -z));
  EXPECT_NE(MapBlock(place, z), MapBlock(place, x));
  EXPECT_NE(MapBlock(place, z), MapBlock(place + 6.0 * x, z));
  EXPECT_NE(MapBlock(-place, z), MapBlock(place, z));
}

}  // namespace
}  // namespace planegraph
