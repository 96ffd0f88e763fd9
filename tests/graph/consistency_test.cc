#include "planegraph/graph/consistency.h"

#include <gtest/gtest.h>

#include <random>
#include <stdexcept>

#include "graph/largest_clique.h"
#include "planegraph/geometry/rotation.h"
#include "planegraph/graph/pose_error.h"

namespace planegraph {
namespace {

constexpr double kSigmaMetres = 0.02, kSigmaRadians = 0.003;

Matrix6d Covariance() {
  Vector6d sigma;
  sigma << Eigen::Vector3d::Constant(kSigmaMetres), Eigen::Vector3d::Constant(kSigmaRadians);
  return sigma.cwiseAbs2().asDiagonal();
}

Vector6d Normal(std::mt19937_64* rng) {
  std::normal_distribution<double> normal;
  Vector6d v;
  for (int i = 0; i < 6; ++i) v[i] = normal(*rng);
  return v;
}

Rigid3 Perturbed(const Rigid3& pose, const Vector6d& by) {
  return {ExpSO3(by.tail<3>()) * pose.rotation, pose.translation + by.head<3>()};
}

Rigid3 RandomPose(std::mt19937_64* rng) {
  const Vector6d v = Normal(rng);
  return {ExpSO3(v.tail<3>()), 3.0 * v.head<3>()};
}

// A drive of three rounds along one circle: scans of different rounds close loops.
struct Drive {
  static constexpr int kRound = 12, kPoses = 36;
  std::vector<Rigid3> truth;
  std::vector<RelativePose> way;
  std::mt19937_64 rng;

  explicit Drive(std::uint64_t seed, double noise = 1.0) : rng(seed) {
    const Rigid3 step(ExpSO3({0.0, 0.0, 2.0 * 3.14159265358979 / kRound}), {2.0, 0.1, 0.0});
    for (int i = 0; i < kPoses; ++i) {
      truth.push_back(i == 0 ? Rigid3() : truth.back() * step);
      if (i > 0) way.push_back(Measure(i - 1, i, noise));
    }
  }
  RelativePose Measure(int target, int source, double noise = 1.0) {
    Vector6d error = noise * Normal(&rng);
    error.head<3>() *= kSigmaMetres, error.tail<3>() *= kSigmaRadians;
    return {target, source, Perturbed(truth[target].Inverse() * truth[source], error),
            Covariance()};
  }
  std::vector<RelativePose> TrueClosures(double noise = 1.0) {
    std::vector<RelativePose> closures;
    for (int i = 0; i + kRound < kPoses; i += 2) closures.push_back(Measure(i, i + kRound, noise));
    return closures;
  }
  // `count` scans in a row taken for those one bay away, all alike.
  std::vector<RelativePose> FalseRun(int target, int source, int count, const Vector6d& off) {
    std::vector<RelativePose> run;
    for (int k = 0; k < count; ++k) {
      run.push_back(Measure(target + k, source + k));
      // One wrong motion of the whole, seen from each of the targets.
      const Rigid3 wrong(ExpSO3(off.tail<3>()), off.head<3>());
      const Rigid3& world = truth[target + k];
      run.back().target_from_source =
          world.Inverse() * wrong * world * run.back().target_from_source;
    }
    return run;
  }
};

Vector6d OneBay() { return (Vector6d() << 1.5, 0.8, 0.0, 0.0, 0.0, 0.05).finished(); }

std::vector<RelativePose> Joined(std::vector<RelativePose> a, const std::vector<RelativePose>& b) {
  a.insert(a.end(), b.begin(), b.end());
  return a;
}

TEST(RelativePose, CovariancesOfChainsAndInversesAreOfFirstOrder) {
  std::mt19937_64 rng(3);
  for (int n = 0; n < 50; ++n) {
    const Vector6d da = 1e-6 * Normal(&rng), db = 1e-6 * Normal(&rng);
    const RelativePose a{0, 1, RandomPose(&rng), da * da.transpose()};
    const RelativePose b{1, 2, RandomPose(&rng), Matrix6d::Zero()};
    const RelativePose c{1, 2, b.target_from_source, db * db.transpose()};
    const auto expect = [](const RelativePose& found, const Rigid3& moved) {
      const Vector6d error = PoseError(moved, found.target_from_source);
      EXPECT_LT((found.covariance - error * error.transpose()).norm(), 1e-4 * error.squaredNorm());
    };
    const Rigid3 moved_a = Perturbed(a.target_from_source, da);
    expect(Inverse(a), moved_a.Inverse());
    expect(Compose(a, b), moved_a * b.target_from_source);
    const RelativePose exact{0, 1, a.target_from_source, Matrix6d::Zero()};
    expect(Compose(exact, c), a.target_from_source * Perturbed(b.target_from_source, db));
  }
}

TEST(RelativePose, TheInverseOfTheInverseIsItself) {
  std::mt19937_64 rng(4);
  const RelativePose a{3, 5, RandomPose(&rng), Covariance()};
  const RelativePose b = Inverse(Inverse(a));
  EXPECT_EQ(b.target, 3);
  EXPECT_EQ(b.source, 5);
  EXPECT_LT(PoseError(a.target_from_source, b.target_from_source).norm(), 1e-12);
  EXPECT_LT((a.covariance - b.covariance).norm(), 1e-12);
}

TEST(ConsistentSet, LosesNothingThatIsRight) {
  for (std::uint64_t seed = 0; seed < 50; ++seed) {
    Drive drive(seed);
    const auto closures = drive.TrueClosures();
    EXPECT_TRUE(FindConsistentSet(Drive::kPoses, drive.way, closures).refused.empty()) << seed;
  }
}

TEST(ConsistentSet, RefusesACoherentRunAndSaysWhatItContradicts) {
  for (std::uint64_t seed = 0; seed < 20; ++seed) {
    Drive drive(seed);
    const auto right = drive.TrueClosures();
    const auto closures = Joined(right, drive.FalseRun(2, 26, 8, OneBay()));
    const ConsistentSet set = FindConsistentSet(Drive::kPoses, drive.way, closures);
    for (std::size_t k = 0; k < closures.size(); ++k) {
      EXPECT_EQ(set.consistent[k], k < right.size()) << seed << " " << k;
    }
    ASSERT_EQ(set.refused.size(), 8u);
    for (const Inconsistency& reason : set.refused) {
      EXPECT_TRUE(reason.with_way || !reason.against.empty());
      EXPECT_GT(reason.chi2, reason.limit);
      for (const std::size_t k : reason.against) EXPECT_TRUE(set.consistent[k]);
    }
  }
}

// Two robots that nothing trusted joins: the closures between them have only each other.
TEST(ConsistentSet, BetweenRobotsTheLargerAgreementWins) {
  for (std::uint64_t seed = 0; seed < 20; ++seed) {
    Drive drive(seed);
    std::vector<RelativePose> way = drive.way;
    std::erase_if(way, [](const RelativePose& step) { return step.source == 18; });
    std::vector<RelativePose> closures;
    for (int k = 0; k < 6; ++k) closures.push_back(drive.Measure(2 + k, 20 + k));
    closures = Joined(closures, drive.FalseRun(8, 28, 5, OneBay()));
    const ConsistentSet set = FindConsistentSet(Drive::kPoses, way, closures);
    for (std::size_t k = 0; k < closures.size(); ++k) EXPECT_EQ(set.consistent[k], k < 6) << k;
    for (const Inconsistency& reason : set.refused) {
      EXPECT_FALSE(reason.with_way);
      EXPECT_EQ(reason.against.size(), 6u);
    }
  }
}

TEST(ConsistentSet, DoesNotDependOnWhichEndIsTheTarget) {
  for (std::uint64_t seed = 0; seed < 10; ++seed) {
    Drive drive(seed);
    auto closures = Joined(drive.TrueClosures(), drive.FalseRun(1, 22, 6, OneBay()));
    const auto before = FindConsistentSet(Drive::kPoses, drive.way, closures).consistent;
    for (std::size_t k = 0; k < closures.size(); k += 2) closures[k] = Inverse(closures[k]);
    EXPECT_EQ(FindConsistentSet(Drive::kPoses, drive.way, closures).consistent, before);
  }
}

TEST(ConsistentSet, WithoutCyclesNothingIsRefused) {
  Drive drive(1);
  const ConsistentSet set =
      FindConsistentSet(Drive::kPoses, {}, drive.FalseRun(1, 22, 6, OneBay()));
  EXPECT_TRUE(set.refused.empty());
  EXPECT_TRUE(FindConsistentSet(Drive::kPoses, drive.way, {}).consistent.empty());
}

TEST(ConsistentSet, IndicesOutOfRangeAreRefused) {
  Drive drive(1);
  EXPECT_THROW(FindConsistentSet(3, drive.way, {}), std::invalid_argument);
  EXPECT_THROW(FindConsistentSet(36, drive.way, {{0, 36, {}, Covariance()}}),
               std::invalid_argument);
}

// Against all subsets.
TEST(LargestClique, IsThatOfBruteForce) {
  constexpr unsigned kVertices = 11;
  std::mt19937_64 rng(11);
  for (int n = 0; n < 60; ++n) {
    std::bernoulli_distribution neighbours(0.2 + 0.01 * n);
    std::vector<std::vector<bool>> adjacent(kVertices, std::vector<bool>(kVertices, false));
    for (unsigned a = 0; a < kVertices; ++a) {
      for (unsigned b = 0; b < a; ++b) adjacent[a][b] = adjacent[b][a] = neighbours(rng);
    }
    const auto is_clique = [&](const std::vector<std::size_t>& set) {
      for (const std::size_t a : set) {
        for (const std::size_t b : set) {
          if (a != b && !adjacent[a][b]) return false;
        }
      }
      return true;
    };
    std::size_t largest = 0;
    for (unsigned subset = 0; subset < 1u << kVertices; ++subset) {
      std::vector<std::size_t> set;
      for (unsigned a = 0; a < kVertices; ++a) {
        if (subset >> a & 1u) set.push_back(a);
      }
      if (set.size() > largest && is_clique(set)) largest = set.size();
    }
    const auto found = LargestClique(adjacent, 100000);
    EXPECT_TRUE(is_clique(found));
    EXPECT_EQ(found.size(), largest) << n;
    const auto greedy = LargestClique(adjacent, 1);
    EXPECT_TRUE(is_clique(greedy) && !greedy.empty()) << "where the steps run out";
  }
}

TEST(VarianceFactor, IsWhatTheNoiseIsAlsoWhereMostClosuresAreFalse) {
  for (const double noise : {1.0, 3.0}) {
    double sum = 0.0;
    for (std::uint64_t seed = 0; seed < 40; ++seed) {
      Drive drive(seed, noise);
      const auto closures = Joined(drive.TrueClosures(noise), drive.FalseRun(2, 26, 8, OneBay()));
      sum += MeasureVarianceFactor(Drive::kPoses, drive.way, closures) / 40;
    }
    // The lower quartile of all is the median of the true ones here: 5.35 over 3.45 too large.
    EXPECT_GT(sum, noise * noise);
    EXPECT_LT(sum, 2.2 * noise * noise);
  }
}

TEST(VarianceFactor, IsOneWhereNothingCanBeCompared) {
  Drive drive(1);
  EXPECT_EQ(MeasureVarianceFactor(Drive::kPoses, {}, drive.TrueClosures()), 1.0);
  EXPECT_EQ(MeasureVarianceFactor(Drive::kPoses, drive.way, {}), 1.0);
}

TEST(GroupClosures, JoinsWhatIsNearAndAgrees) {
  for (std::uint64_t seed = 0; seed < 20; ++seed) {
    Drive drive(seed);
    std::vector<RelativePose> closures;
    for (int k = 0; k < 4; ++k) closures.push_back(drive.Measure(k, k + 24));  // the true run
    closures = Joined(closures, drive.FalseRun(0, 25, 4, OneBay()));           // near to it
    closures.push_back(drive.Measure(16, 28));                                 // far from both
    closures.push_back(Inverse(drive.Measure(4, 28)));  // goes on with the first, turned around
    const auto groups = GroupClosures(Drive::kPoses, drive.way, closures, 2);
    EXPECT_EQ(groups, (std::vector<int>{0, 0, 0, 0, 1, 1, 1, 1, 2, 0})) << seed;
  }
}

}  // namespace
}  // namespace planegraph
