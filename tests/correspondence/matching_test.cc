#include <gtest/gtest.h>

#include <algorithm>
#include <numbers>
#include <random>

#include "correspondence/rotation_hypotheses.h"
#include "correspondence/translation_votes.h"
#include "planegraph/correspondence/hypotheses.h"
#include "planegraph/segmentation/segmenter.h"
#include "segmentation/ray_world.h"

namespace planegraph {
namespace {

PlaneSet PlanesOf(const RayWorld& world, const Rigid3& pose, std::uint64_t seed) {
  return SegmentPlanes(ScanWorld(world, pose, 30000, {0.005, 0.0}, seed).cloud).planes;
}

double WeightIn(const std::vector<VotePeak>& votes, double low, double high) {
  double weight = 0.0;
  for (const auto& vote : votes) {
    if (vote.value >= low && vote.value <= high) weight += vote.weight;
  }
  return weight;
}

TEST(FindPeaks, TheBestPeakIsTheHeaviestWindowOfAll) {
  std::mt19937_64 engine(1);
  std::uniform_real_distribution<double> uniform(0.0, 1.0);
  for (int run = 0; run < 200; ++run) {
    std::vector<VotePeak> votes;
    const int count = 1 + static_cast<int>(40 * uniform(engine));
    for (int i = 0; i < count; ++i) votes.push_back({10.0 * uniform(engine), uniform(engine)});
    constexpr double kWidth = 0.5;
    double heaviest = 0.0;  // a window that is best can be moved until it starts at a vote
    for (const auto& v : votes) {
      heaviest = std::max(heaviest, WeightIn(votes, v.value, v.value + kWidth));
    }
    const auto peaks = FindPeaks(votes, kWidth, 5);
    ASSERT_FALSE(peaks.empty());
    EXPECT_NEAR(peaks[0].weight, heaviest, 1e-9);
    for (std::size_t i = 0; i < peaks.size(); ++i) {
      // The peak is a mean of votes that one window holds.
      EXPECT_GE(WeightIn(votes, peaks[i].value - kWidth, peaks[i].value + kWidth),
                peaks[i].weight - 1e-9);
      for (std::size_t k = 0; k < i; ++k) {
        EXPECT_GE(std::abs(peaks[i].value - peaks[k].value), kWidth);
        EXPECT_LE(peaks[i].weight, peaks[k].weight + 1e-9);
      }
    }
  }
  EXPECT_TRUE(FindPeaks({}, 1.0, 3).empty());
}

TEST(FindRotations, FindsTheRotationAmongTheBest) {
  std::mt19937_64 engine(2);
  std::normal_distribution<double> normal;
  for (int run = 0; run < 20; ++run) {
    const auto vector = [&] {
      return Eigen::Vector3d(normal(engine), normal(engine), normal(engine));
    };
    const Eigen::Quaterniond truth = ExpSO3(vector());
    std::vector<DirectionCluster> source, target;
    for (int k = 0; k < 6; ++k) {
      const Eigen::Vector3d n = vector().normalized();
      source.push_back({n, 3.0 - 0.3 * k, {}});
      target.push_back({truth * n, 3.0 - 0.3 * k, {}});
    }
    const auto found = FindRotations(target, source, 24);
    ASSERT_FALSE(found.empty());
    double best = 10.0;
    for (const auto& f : found) {
      best = std::min(best, AngleBetween(Eigen::Quaterniond(f.target_from_source), truth));
      EXPECT_NEAR(f.target_from_source.determinant(), 1.0, 1e-9);
    }
    EXPECT_LT(best, 8.0 * std::numbers::pi / 180.0) << "the stated distance between hypotheses";
    EXPECT_LT(AngleBetween(Eigen::Quaterniond(found[0].target_from_source), truth), 0.05);
  }
}

TEST(FindRotations, ParallelPlanesGiveNone) {
  const std::vector<DirectionCluster> one = {{Eigen::Vector3d::UnitZ(), 1.0, {}}};
  EXPECT_TRUE(FindRotations(one, one, 24).empty());
}

TEST(MeasureSupport, SharesSumToOneAndTellRightFromWrong) {
  const PlaneSet planes = PlanesOf(FurnishedRoom(3), MakePose(0, 0, 1.3, 0), 1);
  const ScanModel model(planes);
  const auto sum = [](const Support& s) { return s.agree + s.violate + s.unknown; };
  const Support same = MeasureSupport(model, model, Rigid3(), 0.2);
  EXPECT_NEAR(sum(same), 1.0, 1e-9);
  EXPECT_GT(same.agree, 0.98);
  EXPECT_GT(same.WorstDirection(), 0.95);
  const Support far = MeasureSupport(model, model, MakePose(200, 0, 0, 0), 0.2);
  EXPECT_NEAR(sum(far), 1.0, 1e-9);
  EXPECT_EQ(far.agree, 0.0);
  const Support shifted = MeasureSupport(model, model, MakePose(-2.5, 0, 0, 0), 0.2);
  EXPECT_LT(shifted.Score(), same.Score() - 0.2);
  EXPECT_GT(shifted.violate, 0.05) << "the wall stands in free space";
}

TEST(MeasureSupport, ADirectionIsFacedByMoreThanHardlyAnySurface) {
  std::mt19937 random(3);
  std::normal_distribution<double> normal;
  for (int trial = 0; trial < 50; ++trial) {
    const Eigen::Matrix3d turn =
        Eigen::Quaterniond(normal(random), normal(random), normal(random), normal(random))
            .normalized()
            .toRotationMatrix();
    // Walls, floor and ceiling of a corridor, and a share of its surfaces that faces along it.
    const auto corridor = [&](double along) {
      Support support;
      support.agree = 0.5;
      const Eigen::Vector3d shares(along, 0.6 - along, 0.4);
      support.agree_by_direction = 0.5 * turn * shares.asDiagonal() * turn.transpose();
      return support;
    };
    EXPECT_FALSE(corridor(0.0).IsFaced(turn.col(0)));
    EXPECT_FALSE(corridor(0.01).IsFaced(turn.col(0)));
    EXPECT_TRUE(corridor(0.04).IsFaced(turn.col(0)));
    EXPECT_TRUE(corridor(0.0).IsFaced(turn.col(1)));
  }
}

TEST(FindHypotheses, TheTruthIsAmongThem) {
  for (std::uint64_t seed = 0; seed < 5; ++seed) {
    const RayWorld room = FurnishedRoom(seed);
    const Rigid3 a = MakePose(0.4, -0.3, 1.3, 0.0), b = MakePose(-0.9, 0.5, 1.4, 2.2, 0.02, 0.03);
    const PlaneSet target = PlanesOf(room, a, 1), source = PlanesOf(room, b, 2);
    const Rigid3 truth = a.Inverse() * b;
    const auto found = FindHypotheses(ScanModel(target), ScanModel(source));
    ASSERT_FALSE(found.empty());
    const auto close = std::count_if(found.begin(), found.end(), [&](const auto& h) {
      return (h.target_from_source.translation - truth.translation).norm() < 0.5 &&
             AngleBetween(h.target_from_source.rotation, truth.rotation) < 0.1;
    });
    EXPECT_GE(close, 1) << seed;
    EXPECT_TRUE(std::is_sorted(found.begin(), found.end(), [](const auto& x, const auto& y) {
      return x.support.Score() > y.support.Score();
    }));
  }
}

TEST(FindHypotheses, RejectedOnesSayWhy) {
  const PlaneSet planes = PlanesOf(FurnishedRoom(1), MakePose(0, 0, 1.3, 0), 1);
  HypothesisOptions options;
  options.keep_rejected = true;
  const auto all = FindHypotheses(ScanModel(planes), ScanModel(planes), options);
  const auto kept = FindHypotheses(ScanModel(planes), ScanModel(planes));
  const auto rejected =
      std::count_if(all.begin(), all.end(), [](const auto& h) { return !h.rejected.empty(); });
  EXPECT_GT(rejected, 0);
  EXPECT_EQ(all.size() - rejected, kept.size());
}

TEST(FindHypotheses, EmptyScansGiveNone) {
  const PlaneSet none, planes = PlanesOf(EmptyRoom({5, 4, 3}), MakePose(0, 0, 1.3, 0), 1);
  EXPECT_TRUE(FindHypotheses(ScanModel(none), ScanModel(planes)).empty());
  EXPECT_TRUE(FindHypotheses(ScanModel(planes), ScanModel(none)).empty());
  EXPECT_TRUE(FindHypotheses(ScanModel(none), ScanModel(none)).empty());
}

}  // namespace
}  // namespace planegraph
