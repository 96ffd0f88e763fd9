#include "correspondence/first_look.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>

#include "planegraph/segmentation/segmenter.h"
#include "segmentation/ray_world.h"

namespace planegraph {
namespace {

PlaneSet PlanesFrom(const Rigid3& pose, std::uint64_t seed) {
  return SegmentPlanes(ScanWorld(FurnishedRoom(3), pose, 30000, {}, seed).cloud).planes;
}

class FirstLookTest : public testing::Test {
 protected:
  FirstLookTest()
      : target_planes_(PlanesFrom(MakePose(0.4, -0.3, 1.3, 0.0), 1)),
        source_planes_(PlanesFrom(MakePose(-0.9, 0.5, 1.4, 1.2), 2)),
        target_(target_planes_),
        source_(source_planes_) {
    std::mt19937_64 engine(7);
    std::uniform_real_distribution<double> metres(-4.0, 4.0);
    for (int k = 0; k < 400; ++k) {
      translations_.emplace_back(metres(engine), metres(engine), 0.2 * metres(engine));
    }
  }

  // Without leaving early.
  double Score(const Eigen::Matrix3d& rotation, const Eigen::Vector3d& t, double gate) const {
    double score = 0.0;
    for (std::size_t k = 0; k < source_.samples.size(); k += 8) {
      const Surfel& s = source_.map.surfels()[source_.samples[k]];
      const Eigen::Vector3d point = rotation * s.mean + t;
      if (target_.map.Find(point, rotation * s.normal, gate, kLeastCosine) >= 0) {
        score += source_.sample_weights[k];
      } else if (target_planes_.range_image.Classify(point, kFreeMargin) ==
                 RangeImage::Space::kFree) {
        score -= source_.sample_weights[k];
      }
    }
    return score;
  }

  void ExpectTheBestExact(double gate) const {
    HypothesisOptions options;
    options.gate = gate;
    const Eigen::Matrix3d rotation = ExpSO3({0, 0, 1.2}).toRotationMatrix();
    FirstLook look(target_, source_, options);
    look.Look(4, rotation, translations_);
    const auto ranked = look.TakeRanked();
    ASSERT_EQ(ranked.size(), translations_.size());
    std::vector<double> scores;
    for (const auto& t : translations_) scores.push_back(Score(rotation, t, gate));
    std::sort(scores.rbegin(), scores.rend());
    for (std::size_t k = 0; k < options.most_verified; ++k) {
      EXPECT_NEAR(ranked[k].score, scores[k], 1e-12);
      EXPECT_NEAR(ranked[k].score, Score(rotation, ranked[k].translation, gate), 1e-12);
      EXPECT_EQ(ranked[k].rotation, 4u);
    }
    for (std::size_t k = options.most_verified; k < ranked.size(); ++k) {
      EXPECT_LE(ranked[k].score, scores[options.most_verified - 1] + 1e-12);
    }
  }

  PlaneSet target_planes_, source_planes_;
  ScanModel target_, source_;
  std::vector<Eigen::Vector3d> translations_;
};

TEST_F(FirstLookTest, TheBestAreThoseOfAWholeLook) { ExpectTheBestExact(0.4); }

TEST_F(FirstLookTest, WiderGatesThanTheFiltersToo) { ExpectTheBestExact(0.7); }

}  // namespace
}  // namespace planegraph
