#include "planegraph/segmentation/noise_model.h"

#include <gtest/gtest.h>

#include <random>

#include "planegraph/segmentation/segmenter.h"
#include "segmentation/ray_world.h"

namespace planegraph {
namespace {

// Variances of small neighbourhoods: chi-square about the model, a share of them spoilt by edges.
std::vector<NoiseSample> DrawSamples(const NoiseModel& truth, double spoilt, int count) {
  std::mt19937_64 engine(3);
  std::uniform_real_distribution<double> uniform(0.0, 1.0);
  std::chi_squared_distribution<double> chi(40.0);
  std::vector<NoiseSample> samples;
  for (int i = 0; i < count; ++i) {
    const double range = 1.0 + 29.0 * uniform(engine);
    const double sigma = truth.AlongBeam(range);
    const double edge = uniform(engine) < spoilt ? 1.0 + 200.0 * uniform(engine) : 1.0;
    samples.push_back({range, sigma * sigma * chi(engine) / 40.0 * edge});
  }
  return samples;
}

TEST(EstimateNoise, RecoversTheModelDespiteEdges) {
  for (const NoiseModel truth : {NoiseModel{0.01, 0.0}, {0.003, 0.0008}, {0.02, 0.0003}}) {
    const NoiseModel found = EstimateNoise(DrawSamples(truth, 0.3, 8000));
    for (const double range : {3.0, 10.0, 25.0}) {
      EXPECT_NEAR(found.AlongBeam(range) / truth.AlongBeam(range), 1.0, 0.12) << range;
    }
  }
}

TEST(EstimateNoise, FallsBackWithoutSamples) {
  const NoiseModel standard;
  for (int count : {0, 1, 29}) {
    const NoiseModel found = EstimateNoise(DrawSamples({0.1, 0.0}, 0.0, count));
    EXPECT_EQ(found.constant, standard.constant);
    EXPECT_EQ(found.per_metre, standard.per_metre);
  }
}

TEST(EstimateNoise, SamplesWithoutScatterGiveAPositiveNoise) {
  const std::vector<NoiseSample> samples(100, NoiseSample{5.0, 0.0});
  EXPECT_GT(EstimateNoise(samples).AlongBeam(5.0), 0.0);
}

TEST(EstimateNoise, FromScansOfKnownNoise) {
  for (const LaserNoise noise : {LaserNoise{0.004, 0.0}, {0.012, 0.0}, {0.004, 0.002}}) {
    const RayScan scan = ScanWorld(FurnishedRoom(1), MakePose(0, 0, 1.2, 0.4), 60000, noise, 7);
    const NoiseModel found = SegmentPlanes(scan.cloud).noise;
    for (const double range : {2.0, 5.0}) {
      EXPECT_NEAR(found.AlongBeam(range) / (noise.constant + noise.per_metre * range), 1.0, 0.2)
          << noise.constant << " at " << range;
    }
  }
}

}  // namespace
}  // namespace planegraph
