// A group of scans in a drone map: found, ambiguous, refused, and the evidence for it.
#include "planegraph/registration/map_registration.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <memory>

#include "planegraph/registration/cell_search.h"
#include "registration/village_map.h"

namespace planegraph {
namespace {

constexpr double kGate = 0.1;

void ExpectNear(const Sim3& found, const Sim3& truth, double metres, double radians) {
  EXPECT_LT((found.translation - truth.translation).norm(), metres);
  EXPECT_LT(AngleBetween(found.rotation, truth.rotation), radians);
}

TEST(LocateInMap, FindsAScanAnywhere) {
  const VillageMap village;
  int seed = 0;
  for (const Rigid3& pose : {MakePose(0, 0, 1.3, 0.4), MakePose(14, -1, 1.3, -2.5, 0.03, 0.02),
                             MakePose(-14, 2, 1.3, 1.7), MakePose(0.5, 8, 1.3, 3.0)}) {
    SCOPED_TRACE(testing::Message() << pose.translation.transpose());
    const MadeScan scan(Village(), pose, ++seed);
    MapLocationOptions options;
    options.prior.upright = true;
    options.threads = 2;
    const MapLocation found = LocateInMap(village.model(), ScanGroup(scan.model()), options);
    ASSERT_EQ(found.status, RegistrationStatus::kOk) << found.reason;
    EXPECT_EQ(found.reason, "");
    ExpectNear(found.candidates.front().refinement.map_from_group, Sim3(pose), 0.05, 0.005);
    EXPECT_NEAR(found.candidates.front().refinement.map_from_group.scale, 1.0, 0.005);
    EXPECT_GT(found.r1, found.r2);
    EXPECT_LE(found.chance, options.most_chance);
  }
}

TEST(LocateInMap, IsEquivariant) {
  const Sim3 motion(1.0, ExpSO3({0.4, -0.8, 2.0}), {40, -7, 12});
  const VillageMap village, moved(Village(), motion);
  const Rigid3 pose = MakePose(0, 0, 1.3, 0.4);
  const MadeScan scan(Village(), pose, 1);
  MapLocationOptions options;
  options.threads = 2;
  for (const VillageMap* map : {&village, &moved}) {
    const MapLocation found = LocateInMap(map->model(), ScanGroup(scan.model()), options);
    ASSERT_EQ(found.status, RegistrationStatus::kOk) << found.reason;
    const Sim3 truth = map == &village ? Sim3(pose) : motion * Sim3(pose);
    ExpectNear(found.candidates.front().refinement.map_from_group, truth, 0.05, 0.005);
  }
}

// What a first robot found counts for the second: a scale that is known well, and is not 1.
TEST(LocateInMap, TheScaleMayBeKnownToBeAnother) {
  const double scale = 1.04;
  const VillageMap map(Village(), Sim3(scale, Eigen::Quaterniond::Identity(), {0, 0, 0}));
  const Rigid3 pose = MakePose(0, 0, 1.3, 0.4);
  const MadeScan scan(Village(), pose, 1);
  MapLocationOptions options;
  options.prior.upright = true;
  options.prior.scale = scale;
  options.prior.sigma_scale = 0.003;
  options.threads = 2;
  const MapLocation found = LocateInMap(map.model(), ScanGroup(scan.model()), options);
  ASSERT_EQ(found.status, RegistrationStatus::kOk) << found.reason;
  const Sim3& best = found.candidates.front().refinement.map_from_group;
  EXPECT_NEAR(best.scale, scale, 0.003);
  EXPECT_LT((best.translation - scale * pose.translation).norm(), 0.05);
}

TEST(LocateInMap, EqualForAnyNumberOfThreads) {
  const VillageMap village;
  const MadeScan scan(Village(), MakePose(0, 0, 1.3, 0.4), 1);
  MapLocationOptions options;
  const MapLocation one = LocateInMap(village.model(), ScanGroup(scan.model()), options);
  options.threads = 3;
  const MapLocation three = LocateInMap(village.model(), ScanGroup(scan.model()), options);
  EXPECT_EQ(one.r1, three.r1);
  EXPECT_EQ(one.r2, three.r2);
  ASSERT_EQ(one.candidates.size(), three.candidates.size());
  for (std::size_t k = 0; k < one.candidates.size(); ++k) {
    const Sim3& a = one.candidates[k].refinement.map_from_group;
    const Sim3& b = three.candidates[k].refinement.map_from_group;
    EXPECT_EQ(a.translation, b.translation);
    EXPECT_EQ(a.rotation.coeffs(), b.rotation.coeffs());
  }
}

TEST(LocateInMap, CandidatesAreDifferentPlaces) {
  const VillageMap village;
  const MadeScan scan(Village(), MakePose(0, 0, 1.3, 0.4), 1);
  const MapLocation found = LocateInMap(village.model(), ScanGroup(scan.model()), {});
  ASSERT_GE(found.candidates.size(), 2u);
  for (std::size_t a = 1; a < found.candidates.size(); ++a) {
    const Sim3& one = found.candidates[a].refinement.map_from_group;
    for (std::size_t b = 1; b < a; ++b) {
      const Sim3& other = found.candidates[b].refinement.map_from_group;
      EXPECT_TRUE((one.translation - other.translation).norm() >= 2.0 ||
                  AngleBetween(one.rotation, other.rotation) >= 0.1);
    }
  }
}

// Houses that a turn by 180 degrees maps onto each other, around a scanner in the middle.
RayWorld TwoFold() {
  RayWorld world;
  world.AddFace({0, 0, 0}, Eigen::Vector3d::UnitZ(), 20.0, 25.0);
  for (const double side : {0.0, std::numbers::pi}) {
    const Eigen::Quaterniond turn = ExpSO3({0, 0, side});
    AddHouse(turn * Eigen::Vector3d(9, 5, 0), {8, 6, 5}, 0.1 + side, &world);
    AddHouse(turn * Eigen::Vector3d(-3, 9, 0), {4, 5, 4}, 0.5 + side, &world);
    AddHouse(turn * Eigen::Vector3d(12, -6, 0), {5, 6, 6}, -0.2 + side, &world);
  }
  return world;
}

TEST(LocateInMap, TheBestCandidateComesFirstAndItsChanceIsAProbability) {
  const VillageMap map(TwoFold());
  for (int seed = 1; seed <= 12; ++seed) {
    SCOPED_TRACE(seed);
    // A scan of another place: its best poses are all wrong, and nearly as good as each other.
    const MadeScan scan(Village(), MakePose(1.0 * seed - 6.0, 0.2, 1.3, 0.3 * seed), seed);
    MapLocationOptions options;
    options.threads = 2;
    options.prior.upright = true;
    const MapLocation found = LocateInMap(map.model(), ScanGroup(scan.model()), options);
    for (std::size_t k = 1; k < found.candidates.size(); ++k) {
      EXPECT_LE(found.candidates[k].probability, found.candidates[k - 1].probability);
    }
    EXPECT_GE(found.r1, found.r2);
    EXPECT_LE(found.chance, 1.0);
  }
}

TEST(LocateInMap, ATwoFoldSymmetryIsAmbiguous) {
  const VillageMap map(TwoFold());
  const Rigid3 pose = MakePose(0.5, 0.2, 1.3, 0.4);
  const MadeScan scan(TwoFold(), pose, 1);
  MapLocationOptions options;
  options.threads = 2;
  options.prior.upright = true;
  const MapLocation found = LocateInMap(map.model(), ScanGroup(scan.model()), options);
  EXPECT_EQ(found.status, RegistrationStatus::kAmbiguous);
  EXPECT_NE(found.reason, "");
  ASSERT_GE(found.candidates.size(), 2u);
  // The two best are the truth and its twin.
  const Sim3 truth(pose), twin = Sim3(Rigid3(ExpSO3({0, 0, std::numbers::pi}), {0, 0, 0})) * truth;
  const Sim3& a = found.candidates[0].refinement.map_from_group;
  const Sim3& b = found.candidates[1].refinement.map_from_group;
  const bool a_is_truth = (a.translation - truth.translation).norm() < 0.5 &&
                          AngleBetween(a.rotation, truth.rotation) < 0.1;
  ExpectNear(a, a_is_truth ? truth : twin, 0.2, 0.02);
  ExpectNear(b, a_is_truth ? twin : truth, 0.2, 0.02);
  // A rough heading settles it.
  options.prior.pose = MapPrior::Pose{MakePose(1.0, -0.2, 1.0, 0.6), 1.0, 0.2};
  const MapLocation guided = LocateInMap(map.model(), ScanGroup(scan.model()), options);
  ASSERT_EQ(guided.status, RegistrationStatus::kOk) << guided.reason;
  ExpectNear(guided.candidates.front().refinement.map_from_group, truth, 0.05, 0.005);
}

// A street along x without end, of houses at different depths, and one wall across it.
RayWorld Street(double wall_x) {
  RayWorld world;
  world.AddFace({0, 0, 0}, Eigen::Vector3d::UnitZ(), 14.0, 45.0);
  for (const double side : {-1.0, 1.0}) {
    const Eigen::Vector3d normal(0, -side, 0);
    world.AddFace({-25, side * 7.0, 3.0}, normal, 20.0, 3.0);
    world.AddFace({25, side * 8.5, 2.0}, normal, 20.0, 2.0);
  }
  world.AddFace({wall_x, 4.5, 1.5}, -Eigen::Vector3d::UnitX(), 1.0, 1.5);
  return world;
}

// The map has the wall's other side, or another wall: what is left along the street is its word.
TEST(LocateInMap, APoseThatOneWallHoldsInADirectionIsNotOk) {
  const VillageMap map(Street(12.4));
  const Rigid3 pose = MakePose(0, 0, 1.3, 0.1);
  const MadeScan scan(Street(12.0), pose, 1, 60000);
  MapLocationOptions options;
  options.threads = 2;
  options.prior.upright = true;
  options.prior.pose = MapPrior::Pose{MakePose(0.5, -0.5, 1.5, 0.2), 1.0, 0.17};
  const MapLocation found = LocateInMap(map.model(), ScanGroup(scan.model()), options);
  EXPECT_NE(found.status, RegistrationStatus::kOk);
  EXPECT_GT(found.slid.probability, options.most_chance);
  // Along the street, in the map's axes, by more than what is one place.
  EXPECT_GT(std::abs(found.slid.direction.x()), 0.95);
  EXPECT_NEAR(found.slid.direction.norm(), 1.0, 1e-9);
  EXPECT_GT(found.slid.metres, MapRefinementOptions().last_gate);
  EXPECT_THAT(found.reason, testing::HasSubstr(" m beside it, along ("));
}

TEST(LocateInMap, AScanOfElsewhereIsRefused) {
  const VillageMap village;
  const MadeScan inside(FurnishedRoom(2), MakePose(0, 0, 1.3, 0.3), 1);
  MapLocationOptions options;
  options.threads = 2;
  const MapLocation found = LocateInMap(village.model(), ScanGroup(inside.model()), options);
  EXPECT_NE(found.status, RegistrationStatus::kOk);
  EXPECT_NE(found.reason, "");
}

TEST(LocateInMap, NothingInNothingFailsWithAReason) {
  const PlaneSet nothing;
  const MapModel empty_map(nothing);
  const ScanModel empty_scan(nothing);
  const VillageMap village;
  const MadeScan scan(Village(), MakePose(0, 0, 1.3, 0.4), 1);
  const std::pair<const MapModel*, const ScanModel*> pairs[] = {
      {&empty_map, &scan.model()}, {&village.model(), &empty_scan}, {&empty_map, &empty_scan}};
  for (const auto& [map, model] : pairs) {
    const MapLocation found = LocateInMap(*map, ScanGroup(*model), {});
    EXPECT_EQ(found.status, RegistrationStatus::kFailed);
    EXPECT_NE(found.reason, "");
    EXPECT_TRUE(found.candidates.empty());
  }
}

// Rays of a scan with several in each pixel of its range image: what lies between two rays over the
// ground far away looks free.
constexpr int kDense = 150000;

TEST(MeasureEvidence, TheTruthHasItAndAWrongPlaceHasNot) {
  const VillageMap village;
  const Rigid3 pose = MakePose(0, 0, 1.3, 0.4);
  const MadeScan scan(Village(), pose, 1, kDense);
  const ScanGroup group(scan.model());
  const MapEvidence truth = MeasureEvidence(village.model(), group, Sim3(pose), kGate);
  EXPECT_GT(truth.agree, 0.8);
  EXPECT_GT(truth.worst_direction, 0.7);
  EXPECT_LT(truth.pierced, 0.1);
  ASSERT_EQ(truth.agree_by_scan.size(), 1u);
  EXPECT_NEAR(truth.agree_by_scan[0], truth.agree, 1e-12);
  for (const auto& wrong : {MakePose(1.5, 1.0, 1.3, 0.4), MakePose(0, 0, 1.3, 0.9),
                            MakePose(0, 0, 2.5, 0.4), MakePose(14, -1, 1.3, 0.4)}) {
    const MapEvidence evidence = MeasureEvidence(village.model(), group, Sim3(wrong), kGate);
    EXPECT_LT(LogLikelihoodRatio(evidence, 0.3), 0.3 * LogLikelihoodRatio(truth, 0.3));
  }
}

TEST(MeasureEvidence, AWallThatTheLaserLookedThroughIsPierced) {
  RayWorld built = Village();
  // What the scanner did not see: walls two metres from it, 72 m^2 of some 1500 m^2 about it.
  for (const Eigen::Vector3d& side : {Eigen::Vector3d(1, 0, 0), Eigen::Vector3d(0, 1, 0),
                                      Eigen::Vector3d(-1, 0, 0), Eigen::Vector3d(0, -1, 0)}) {
    built.AddFace(2.2 * side + Eigen::Vector3d(0, 0, 1.5), -side, 3.0, 1.5);
  }
  const VillageMap village, with_walls(built);
  const Rigid3 pose = MakePose(0, 0, 1.3, 0.4);
  const MadeScan scan(Village(), pose, 1, kDense);
  const ScanGroup group(scan.model());
  const MapEvidence free = MeasureEvidence(village.model(), group, Sim3(pose), kGate);
  const MapEvidence pierced = MeasureEvidence(with_walls.model(), group, Sim3(pose), kGate);
  EXPECT_LT(free.pierced, 0.02);
  EXPECT_GT(pierced.pierced, free.pierced + 0.02);
}

TEST(MeasureEvidence, SurfacesInTheMapsFreeAirAreContradicted) {
  const VillageMap village;
  const Rigid3 pose = MakePose(0, 0, 1.3, 0.4);
  const MadeScan scan(Village(), pose, 1);
  const ScanGroup group(scan.model());
  const MapEvidence truth = MeasureEvidence(village.model(), group, Sim3(pose), kGate);
  EXPECT_LT(truth.contradicted, 0.02);
  // Three metres above the ground all that faced up is in the air, and the ground confirms nothing.
  const MapEvidence high =
      MeasureEvidence(village.model(), group, Sim3(MakePose(0, 0, 4.3, 0.4)), kGate);
  EXPECT_GT(high.contradicted, 0.2);
  EXPECT_LT(high.confirmed, truth.confirmed);
  // Below the ground the map has seen nothing.
  const MapEvidence low =
      MeasureEvidence(village.model(), group, Sim3(MakePose(0, 0, -40.0, 0.4)), kGate);
  EXPECT_EQ(low.contradicted, 0.0);
  EXPECT_EQ(low.confirmed, 0.0);
}

// Expected values by the binomial distribution: log(0.9^18 0.1^2 / (0.3^18 0.7^2)).
TEST(LogLikelihoodRatio, IsThatOfIndependentTrials) {
  MapEvidence evidence;
  evidence.surfaces = 20.0;
  evidence.confirmed = 0.9;
  evidence.contradicted = 0.1;
  const double expected = 18.0 * std::log(0.9 / 0.3) + 2.0 * std::log(0.1 / 0.7);
  EXPECT_NEAR(LogLikelihoodRatio(evidence, 0.3), expected, 1e-12);
  // What the map says nothing of is neither for nor against.
  evidence.surfaces = 40.0;
  evidence.confirmed = 0.45;
  evidence.contradicted = 0.05;
  EXPECT_NEAR(LogLikelihoodRatio(evidence, 0.3), expected, 1e-12);
  EXPECT_EQ(LogLikelihoodRatio(MapEvidence(), 0.3), 0.0);
}

TEST(LogLikelihoodRatio, WhatIsLookedThroughSpeaksAgainstThePoseBeyondWhatIsToBeExpected) {
  MapEvidence evidence;
  evidence.viewed = 20.0;
  evidence.pierced = 0.1;
  EXPECT_EQ(LogLikelihoodRatio(evidence, 0.3), 0.0);
  evidence.pierced = 0.5;
  const double some = LogLikelihoodRatio(evidence, 0.3);
  // Chernoff's bound lies above the tail of the distribution: P(X >= 10 of 20 | 0.15) = 2.5e-4.
  EXPECT_GE(some, std::log(2.5e-4));
  EXPECT_LT(some, std::log(1e-2));
  evidence.pierced = 1.0;
  EXPECT_NEAR(LogLikelihoodRatio(evidence, 0.3), 20.0 * std::log(0.15), 1e-12);
}

TEST(BackgroundShare, IsThatOfTheWrongPosesWithinItsLimits) {
  MapEvidence a, b;
  a.confirmed = 0.2, a.contradicted = 0.6;
  b.confirmed = 0.1, b.contradicted = 0.1;
  EXPECT_NEAR(BackgroundShare({&a, &b}), 0.3, 1e-12);
  EXPECT_EQ(BackgroundShare({}), 0.5);
  b.contradicted = 0.0;
  EXPECT_EQ(BackgroundShare({&b}), 0.5);
}

TEST(MeasureEvidence, AGroupMayGoOnWhereTheMapDoesNot) {
  const VillageMap village;
  const Rigid3 pose = MakePose(0, 0, 1.3, 0.4);
  const MadeScan scan(Village(), pose, 1), elsewhere(FurnishedRoom(2), MakePose(0, 0, 1.3, 0), 2);
  ScanGroup group(scan.model());
  const MapEvidence alone = MeasureEvidence(village.model(), group, Sim3(pose), kGate);
  group.scans.push_back(&elsewhere.model());
  group.group_from_scan.push_back(MakePose(100, 0, 0, 0));
  const MapEvidence both = MeasureEvidence(village.model(), group, Sim3(pose), kGate);
  EXPECT_NEAR(both.agree, alone.agree, 1e-12);
  ASSERT_EQ(both.agree_by_scan.size(), 2u);
  EXPECT_LT(both.agree_by_scan[1], 0.05);
}

TEST(MapCorrespondences, AreTheSameSurfaces) {
  const VillageMap village;
  const Rigid3 pose = MakePose(0, 0, 1.3, 0.4);
  const MadeScan scan(Village(), pose, 1);
  const auto pairs = MapCorrespondences(village.model(), scan.model(), Sim3(pose), kGate);
  EXPECT_GE(pairs.size(), 6u);
  for (const PlanePair& pair : pairs) {
    const Plane moved = Transform(pose, scan.planes().planes[pair.source].plane);
    const PlaneSegment& seen = village.planes().planes[pair.target];
    EXPECT_GT(moved.normal.dot(seen.plane.normal), 0.9);
    EXPECT_LT(std::abs(moved.SignedDistance(seen.centroid())), 1.0);
  }
}

TEST(LocateByCells, TheTruthIsAmongTheCandidates) {
  const VillageMap village;
  const Rigid3 pose = MakePose(0, 0, 1.3, 0.4);
  const MadeScan scan(Village(), pose, 1);
  CellSearchOptions options;
  options.threads = 2;
  const MapLocation found = LocateByCells(village.planes(), scan.planes(), options);
  EXPECT_GE(found.r1, found.r2);
  EXPECT_EQ(found.reason.empty(), found.status == RegistrationStatus::kOk);
  bool near = false;
  for (std::size_t k = 0; k < found.candidates.size(); ++k) {
    const auto& candidate = found.candidates[k];
    EXPECT_LE(candidate.evidence.agree, found.candidates[k == 0 ? 0 : k - 1].evidence.agree);
    const Sim3& at = candidate.refinement.map_from_group;
    near = near || ((at.translation - pose.translation).norm() < 2.0 &&
                    AngleBetween(at.rotation, pose.rotation) < 0.1);
  }
  EXPECT_TRUE(near);
}

TEST(LocateByCells, SaysFailedAndAmbiguousWithReasons) {
  const VillageMap village;
  const MadeScan scan(Village(), MakePose(0, 0, 1.3, 0.4), 1);
  CellSearchOptions options;
  options.threads = 2;
  options.alpha = 1.1;  // no share is that large
  const MapLocation failed = LocateByCells(village.planes(), scan.planes(), options);
  EXPECT_EQ(failed.status, RegistrationStatus::kFailed);
  EXPECT_NE(failed.reason.find("alpha"), std::string::npos);
  options.alpha = 0.0;
  options.beta = 1e9;
  const MapLocation ambiguous = LocateByCells(village.planes(), scan.planes(), options);
  EXPECT_EQ(ambiguous.status, RegistrationStatus::kAmbiguous);
  EXPECT_NE(ambiguous.reason.find("beta"), std::string::npos);
}

TEST(LocateByCells, NothingInNothingFails) {
  const PlaneSet nothing;
  const MapLocation found = LocateByCells(nothing, nothing);
  EXPECT_EQ(found.status, RegistrationStatus::kFailed);
  EXPECT_NE(found.reason, "");
  EXPECT_TRUE(found.candidates.empty());
}

}  // namespace
}  // namespace planegraph
