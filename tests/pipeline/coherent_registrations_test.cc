// Registrations that are wrong together: a stretch of scans taken for another place.
#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <nlohmann/json.hpp>
#include <random>
#include <set>

#include "pipeline/small_site.h"
#include "planegraph/geometry/rotation.h"
#include "planegraph/pipeline/joint_solve.h"
#include "planegraph/pipeline/loop_consistency.h"
#include "planegraph/pipeline/outputs.h"

namespace planegraph {
namespace {

constexpr double kSigmaMetres = 0.005, kSigmaRadians = 0.001;

Vector6d Noise(double metres, double radians, std::mt19937_64* rng) {
  std::normal_distribution<double> normal;
  Vector6d v;
  for (int i = 0; i < 6; ++i) v[i] = (i < 3 ? metres : radians) * normal(*rng);
  return v;
}

Rigid3 Perturbed(const Rigid3& pose, const Vector6d& by) {
  return {ExpSO3(by.tail<3>()) * pose.rotation, pose.translation + by.head<3>()};
}

PairRecord MakePair(std::size_t target, std::size_t source, const Rigid3& target_from_source,
                    std::mt19937_64* rng) {
  PairRecord pair{target, source, {}, true, 0.0};
  pair.registration.status = RegistrationStatus::kOk;
  Refinement& refinement = pair.registration.refinement;
  refinement.target_from_source =
      Perturbed(target_from_source, Noise(kSigmaMetres, kSigmaRadians, rng));
  refinement.covariance.setZero();
  refinement.covariance.diagonal().head<3>().setConstant(kSigmaMetres * kSigmaMetres);
  refinement.covariance.diagonal().tail<3>().setConstant(kSigmaRadians * kSigmaRadians);
  refinement.pairs = 100;
  return pair;
}

// Three rounds of twelve scans through one yard.
struct Rounds {
  static constexpr std::size_t kRound = 12, kScans = 36;
  std::mt19937_64 rng;
  std::vector<ScanRecord> scans{kScans};
  std::vector<Rigid3> truth;
  std::vector<OdometryStep> odometry;
  std::vector<PairRecord> pairs;
  std::set<std::string> wrong;  // TARGET-SOURCE

  explicit Rounds(std::uint64_t seed) : rng(seed) {
    const Rigid3 step(ExpSO3({0.0, 0.0, 2.0 * 3.14159265358979 / kRound}), {2.0, 0.1, 0.0});
    for (std::size_t i = 0; i < kScans; ++i) {
      truth.push_back(i == 0 ? Rigid3() : truth.back() * step);
      scans[i].id = "ugv/" + std::to_string(i);
      if (i == 0) continue;
      const Matrix6d covariance = OdometryCovariance(step);
      const double metres = std::sqrt(covariance(0, 0)), radians = std::sqrt(covariance(3, 3));
      odometry.push_back({i - 1, i, Perturbed(step, Noise(metres, radians, &rng)), covariance});
      pairs.push_back(MakePair(i - 1, i, step, &rng));
    }
    for (std::size_t i = 0; i + kRound < kScans; i += 2) AddTrue(i, i + kRound);
  }
  void AddTrue(std::size_t target, std::size_t source) {
    pairs.push_back(MakePair(target, source, truth[target].Inverse() * truth[source], &rng));
  }
  // `count` scans in a row that were all laid a bay further on.
  void AddWrong(std::size_t target, std::size_t source, std::size_t count) {
    const Rigid3 off(Eigen::Quaterniond::Identity(), {1.6, 0.9, 0.0});
    for (std::size_t k = 0; k < count; ++k) {
      const std::size_t a = target + k, b = source + k;
      pairs.push_back(MakePair(a, b, truth[a].Inverse() * off * truth[b], &rng));
      wrong.insert(scans[a].id + "-" + scans[b].id);
    }
  }
};

MapOptions Graduated() {
  MapOptions options = TwoThreads();
  options.loss = ParseLoss("gnc_tls");
  return options;
}

std::set<std::string> Names(const std::vector<SwitchedOff>& off) {
  std::set<std::string> names;
  for (const SwitchedOff& entry : off) names.insert(entry.target + "-" + entry.source);
  return names;
}

TEST(CoherentRegistrations, AreRefusedByTheirCycles) {
  for (std::uint64_t seed = 1; seed <= 10; ++seed) {
    Rounds rounds(seed);
    rounds.AddWrong(2, 27, 6);
    std::vector<SwitchedOff> off;
    RefuseInconsistentLoops(rounds.scans, rounds.odometry, &rounds.pairs, &off);
    EXPECT_EQ(Names(off), rounds.wrong) << seed;
    for (const SwitchedOff& entry : off) {
      EXPECT_GT(entry.sigmas, entry.threshold_sigmas);
      EXPECT_NE(entry.reason.find("it contradicts"), std::string::npos);
      for (const std::string& name : entry.contradicts) EXPECT_EQ(rounds.wrong.count(name), 0u);
    }
    for (const PairRecord& pair : rounds.pairs) {
      const std::string name = rounds.scans[pair.target].id + "-" + rounds.scans[pair.source].id;
      EXPECT_EQ(pair.used, rounds.wrong.count(name) == 0);
      EXPECT_EQ(pair.registration.status == RegistrationStatus::kAmbiguous, !pair.used);
    }
  }
}

TEST(CoherentRegistrations, AreSwitchedOffByAGraduatedLoss) {
  for (std::uint64_t seed = 1; seed <= 10; ++seed) {
    Rounds rounds(seed);
    rounds.AddWrong(2, 27, 6);
    std::vector<Rigid3> start(Rounds::kScans);
    for (std::size_t i = 1; i < start.size(); ++i) {
      start[i] = start[i - 1] * rounds.odometry[i - 1].target_from_source;
    }
    std::vector<SwitchedOff> off;
    const auto poses =
        SolveRelativePoses(rounds.scans, rounds.odometry, start, Graduated(), &rounds.pairs, &off);
    EXPECT_EQ(Names(off), rounds.wrong) << seed;
    EXPECT_LT(LargestDistance(poses, rounds.truth), 0.1) << seed;
    for (const SwitchedOff& entry : off) {
      EXPECT_EQ(entry.weight, 0.0);
      EXPECT_GT(entry.sigmas, entry.threshold_sigmas);
    }
  }
}

TEST(CoherentRegistrations, OfNoneThatIsRightAnythingIsLost) {
  for (std::uint64_t seed = 1; seed <= 10; ++seed) {
    Rounds rounds(seed);
    std::vector<SwitchedOff> off;
    RefuseInconsistentLoops(rounds.scans, rounds.odometry, &rounds.pairs, &off);
    SolveRelativePoses(rounds.scans, rounds.odometry, rounds.truth, Graduated(), &rounds.pairs,
                       &off);
    EXPECT_TRUE(off.empty()) << seed;
  }
}

class SiteWithCoherentRegistrations : public TestFolder {
 protected:
  SiteWithCoherentRegistrations() {
    WriteSite(Path("yard"), yard_);
    result_ = MapScans(ReadSite(Path("yard/site.yaml")), Graduated());
  }
  // Solves with these registrations from where the odometry has the scans.
  void SolveAgain() {
    Placement placement;
    placement.world_from_scan =
        SolveRelativePoses(result_.scans, result_.odometry,
                           ChainPoses(result_.site, result_.scans, {}, result_.odometry),
                           Graduated(), &result_.pairs, &result_.refused);
    placement.placed.assign(result_.scans.size(), false);
    result_.solution =
        SolveJointly({&result_.site, &result_.scans, &result_.pairs, &result_.odometry,
                      &result_.maps, &result_.map_pairs, &placement, &result_.robot_positions},
                     Graduated());
  }

  SimulatedSite yard_ = SmallSite(SceneKind::kYard, 8, 10);
  MapResult result_;
};

TEST_F(SiteWithCoherentRegistrations, NamesJustThemAndIsSolvedRight) {
  const auto truth = TruthFromFirst(yard_);
  const auto nothing = nlohmann::json::parse(ReportJson(result_, Graduated()))["switched_off"];
  EXPECT_TRUE(nothing.empty()) << nothing.dump();
  const std::vector<Rigid3> clean = result_.solution.world_from_scan;
  EXPECT_LT(LargestDistance(clean, truth), 0.01);

  std::mt19937_64 rng(5);
  std::set<std::string> wrong;
  for (std::size_t k = 0; k < 3; ++k) {
    const std::size_t a = k, b = k + 5;
    const Rigid3 off(Eigen::Quaterniond::Identity(), {2.5, 0.0, 0.0});
    std::erase_if(result_.pairs,
                  [&](const PairRecord& p) { return p.target == a && p.source == b; });
    result_.pairs.push_back(MakePair(a, b, truth[a].Inverse() * off * truth[b], &rng));
    wrong.insert(result_.scans[a].id + "-" + result_.scans[b].id);
  }
  SolveAgain();
  EXPECT_LT(LargestDistance(result_.solution.world_from_scan, clean), 0.002);
  std::set<std::string> named;
  const auto report = nlohmann::json::parse(ReportJson(result_, Graduated()));
  for (const auto& off : report["switched_off"]) {
    named.insert(off["target"].get<std::string>() + "-" + off["source"].get<std::string>());
    EXPECT_EQ(off["kind"], "laser-laser");
    EXPECT_GT(off["sigmas"].get<double>(), off["threshold_sigmas"].get<double>());
    EXPECT_FALSE(off["reason"].get<std::string>().empty());
  }
  EXPECT_EQ(named, wrong);
}

}  // namespace
}  // namespace planegraph
