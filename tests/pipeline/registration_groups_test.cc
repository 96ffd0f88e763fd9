#include <gtest/gtest.h>

#include <utility>

#include "pipeline/group_judgement.h"

namespace planegraph {
namespace {

// Two rounds of ten scans at equal places, and a drone map that scans 1 and 11 are registered to.
class TwoRounds : public testing::Test {
 protected:
  TwoRounds() {
    for (std::size_t i = 0; i < 20; ++i) {
      scans_.emplace_back();
      scans_.back().id = "ugv/" + std::to_string(i);
      if (i > 0) odometry_.push_back({i - 1, i, Step(i), OdometryCovariance(Step(i))});
    }
    for (const std::size_t i : {0u, 1u, 2u, 8u}) AddPair(i, i + 10, {});
    maps_.emplace_back();
    maps_.back().id = "uav";
    for (const std::size_t i : {1u, 11u}) {
      map_pairs_.emplace_back();
      map_pairs_.back().scan = i;
      map_pairs_.back().used = true;
    }
    problem_.scans = &scans_, problem_.pairs = &pairs_, problem_.odometry = &odometry_;
    problem_.maps = &maps_, problem_.map_pairs = &map_pairs_;
  }
  static Rigid3 Step(std::size_t i) {
    return {Eigen::Quaterniond::Identity(), {i == 10 ? -18.0 : 2.0, 0.0, 0.0}};
  }
  void AddPair(std::size_t target, std::size_t source, const Rigid3& pose) {
    PairRecord& pair = pairs_.emplace_back();
    pair.target = target, pair.source = source, pair.used = true;
    pair.registration.refinement.target_from_source = pose;
    pair.registration.refinement.covariance = 1e-4 * Matrix6d::Identity();
  }
  // A landmark seen from these scans and, where `in_map`, in the map.
  static PlaneLandmark Seen(const std::vector<int>& scans, bool in_map = false) {
    PlaneLandmark plane;
    for (const int scan : scans) {
      plane.observations.emplace_back();
      plane.observations.back().pose = scan;
    }
    if (in_map) {
      plane.observations.emplace_back();
      plane.observations.back().map = 0;
    }
    return plane;
  }
  static std::vector<int> GroupsOf(const PlaneLandmark& plane) {
    std::vector<int> groups;
    for (const PlaneObservation& seen : plane.observations) groups.push_back(seen.group);
    return groups;
  }

  std::vector<ScanRecord> scans_;
  std::vector<PairRecord> pairs_;
  std::vector<OdometryStep> odometry_;
  std::vector<MapRecord> maps_;
  std::vector<MapPairRecord> map_pairs_;
  JointProblem problem_;
};

TEST_F(TwoRounds, LoopsOfOneStretchAreOneGroupAndTiesToTheMapEachTheirOwn) {
  const RegistrationGroups groups(problem_);
  EXPECT_EQ(groups.count(), 4);
  EXPECT_EQ(groups.OfPair(0), groups.OfPair(1));
  EXPECT_EQ(groups.OfPair(0), groups.OfPair(2));
  EXPECT_NE(groups.OfPair(0), groups.OfPair(3)) << "six scans further on";
  EXPECT_NE(groups.OfMapPair(0), groups.OfMapPair(1));
}

TEST_F(TwoRounds, ALoopThatDisagreesIsNoneOfTheGroup) {
  AddPair(3, 13, {Eigen::Quaterniond::Identity(), {5.0, 5.0, 0.0}});
  const RegistrationGroups groups(problem_);
  EXPECT_NE(groups.OfPair(0), groups.OfPair(4));
}

TEST_F(TwoRounds, AnObservationBelongsToWhatBroughtItsStretch) {
  const RegistrationGroups groups(problem_);
  const int loop = groups.OfPair(0), tie = groups.OfMapPair(0), other_tie = groups.OfMapPair(1);
  Graph graph;
  graph.planes = {Seen({0, 1, 3, 11, 13}), Seen({4, 5}), Seen({0, 1}, true), Seen({9, 11}, true),
                  Seen({5, 16})};
  groups.Apply(&graph);
  EXPECT_EQ(GroupsOf(graph.planes[0]), (std::vector<int>{-1, -1, -1, loop, loop}));
  EXPECT_EQ(GroupsOf(graph.planes[1]), (std::vector<int>{-1, -1}));
  EXPECT_EQ(GroupsOf(graph.planes[2]), (std::vector<int>{-1, -1, tie}));
  EXPECT_EQ(GroupsOf(graph.planes[3]), (std::vector<int>{-1, -1, other_tie}));
  EXPECT_EQ(GroupsOf(graph.planes[4])[0], -1);
}

// Of what the solver says of two groups: one is off, the other has lost a plane.
TEST_F(TwoRounds, AGroupWithoutWeightIsNamedWithAllOfItsRegistrations) {
  GroupJudgement judgement(problem_);
  Graph graph;
  for (int k = 0; k < 6; ++k) graph.planes.push_back(Seen({k % 3, 10 + k % 3}, true));
  judgement.Apply(&graph);
  SolveSummary summary;
  for (int k = 0; k < 6; ++k) {
    summary.residuals.push_back({{.plane = k, .observation = 0}, 3, 1.0, 1.0});
    summary.residuals.push_back({{.plane = k, .observation = 1}, 3, 900.0, 0.0});
    const bool off = k == 0;
    summary.residuals.push_back(
        {{.plane = k, .observation = 2}, 3, off ? 50.0 : 1.0, off ? 0.0 : 1.0});
  }
  judgement.Record(graph, summary, ParseLoss("gnc_tls"));
  const std::vector<SwitchedOff> off = judgement.Off();
  ASSERT_EQ(off.size(), 3u);
  for (std::size_t k = 0; k < 3; ++k) {
    EXPECT_EQ(off[k].target, scans_[k].id);
    EXPECT_EQ(off[k].source, scans_[k + 10].id);
    EXPECT_EQ(off[k].weight, 0.0);
    EXPECT_DOUBLE_EQ(off[k].sigmas, 30.0);
    EXPECT_NE(off[k].reason.find("6 of the 6 planes"), std::string::npos) << off[k].reason;
  }
  RemoveSwitchedOff(summary, &graph);
  ASSERT_EQ(graph.planes.size(), 5u) << "the first has one observation left";
  for (const PlaneLandmark& plane : graph.planes) {
    ASSERT_EQ(plane.observations.size(), 2u);
    EXPECT_EQ(plane.observations[1].map, 0);
  }
}

}  // namespace
}  // namespace planegraph
