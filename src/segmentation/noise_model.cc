#include "planegraph/segmentation/noise_model.h"

#include <algorithm>
#include <cmath>

#include "planegraph/base/median.h"

namespace planegraph {
namespace {

constexpr std::size_t kLeastSamples = 30;
constexpr std::size_t kMostBins = 8;
// Below a tenth of a millimetre a float's digits and the mesh of a simulated scene end.
constexpr double kLeastSigma = 1e-4;

// Mode of sorted values: the half of the values that lies closest together, again and again.
double HalfSampleMode(const std::vector<double>& sorted) {
  std::size_t first = 0, count = sorted.size();
  while (count > 3) {
    const std::size_t half = (count + 1) / 2;
    std::size_t best = first;
    double width = INFINITY;
    for (std::size_t i = first; i + half <= first + count; ++i) {
      const double w = sorted[i + half - 1] - sorted[i];
      if (w < width) width = w, best = i;
    }
    first = best;
    count = half;
  }
  double sum = 0.0;
  for (std::size_t i = first; i < first + count; ++i) sum += sorted[i];
  return sum / static_cast<double>(count);
}

struct Bin {
  double range, sigma;
};

std::vector<Bin> BinByRange(const std::vector<NoiseSample>& sorted) {
  const std::size_t bins = std::clamp<std::size_t>(sorted.size() / kLeastSamples, 1, kMostBins);
  std::vector<Bin> result;
  for (std::size_t b = 0; b < bins; ++b) {
    const std::size_t begin = b * sorted.size() / bins, end = (b + 1) * sorted.size() / bins;
    std::vector<double> logs;
    double range = 0.0;
    for (std::size_t i = begin; i < end; ++i) {
      logs.push_back(std::log(std::max(sorted[i].variance, kLeastSigma * kLeastSigma)));
      range += sorted[i].range;
    }
    std::sort(logs.begin(), logs.end());
    result.push_back(
        {range / static_cast<double>(end - begin), std::exp(0.5 * HalfSampleMode(logs))});
  }
  return result;
}

// Theil-Sen: the median of all slopes, so that one odd bin (returns of the sky) does not turn the
// line. A negative coefficient is fixed at zero and the other fitted alone.
NoiseModel FitLine(const std::vector<Bin>& bins) {
  std::vector<double> slopes, sigmas, ratios;
  for (std::size_t i = 0; i < bins.size(); ++i) {
    sigmas.push_back(bins[i].sigma);
    ratios.push_back(bins[i].sigma / std::max(bins[i].range, 1e-12));
    for (std::size_t k = 0; k < i; ++k) {
      const double run = bins[i].range - bins[k].range;
      if (run > 1e-6) slopes.push_back((bins[i].sigma - bins[k].sigma) / run);
    }
  }
  const double slope = slopes.empty() ? 0.0 : Median(slopes);
  if (slope <= 0.0) return {std::max(Median(sigmas), kLeastSigma), 0.0};
  std::vector<double> constants;
  for (const Bin& bin : bins) constants.push_back(bin.sigma - slope * bin.range);
  const double constant = Median(constants);
  if (constant <= kLeastSigma) return {kLeastSigma, Median(ratios)};
  return {constant, slope};
}

}  // namespace

NoiseModel EstimateNoise(std::vector<NoiseSample> samples) {
  if (samples.size() < kLeastSamples) return {};
  std::sort(samples.begin(), samples.end(),
            [](const NoiseSample& a, const NoiseSample& b) { return a.range < b.range; });
  return FitLine(BinByRange(samples));
}

}  // namespace planegraph
