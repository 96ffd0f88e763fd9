#include "registration/georeference_fit.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <random>

#include "planegraph/geometry/alignment.h"
#include "registration/georeference_rows.h"

namespace planegraph {
namespace {

using Triple = std::array<std::size_t, 3>;

// Medians of chi-square with 3 and 2 degrees of freedom and of a standard normal's magnitude, and
// the 99.9 % point of chi-square with 3.
constexpr double kMedian3 = 2.366, kMedian2 = 1.386, kMedianMagnitude = 0.6745, kGate = 16.27;
// Cauchy's scale, in squared standard deviations of three axes.
constexpr double kCauchy = 6.0;
constexpr int kRounds = 20;

std::vector<Triple> AllTriples(std::size_t count) {
  std::vector<Triple> triples;
  for (std::size_t i = 0; i < count; ++i) {
    for (std::size_t j = i + 1; j < count; ++j) {
      for (std::size_t k = j + 1; k < count; ++k) triples.push_back({i, j, k});
    }
  }
  return triples;
}

// (The distributions of <random> differ between libraries; the engine does not.)
std::vector<Triple> Triples(std::size_t count, std::uint64_t seed, int samples) {
  const double all = static_cast<double>(count) * (count - 1.0) * (count - 2.0) / 6.0;
  if (all <= samples) return AllTriples(count);
  std::mt19937_64 engine(seed);
  std::vector<Triple> triples;
  while (triples.size() < static_cast<std::size_t>(samples)) {
    const Triple t = {engine() % count, engine() % count, engine() % count};
    if (t[0] != t[1] && t[0] != t[2] && t[1] != t[2]) triples.push_back(t);
  }
  return triples;
}

double UpperMedian(std::vector<double>* values) {
  const auto middle = values->begin() + static_cast<std::ptrdiff_t>(values->size() / 2);
  std::nth_element(values->begin(), middle, values->end());
  return *middle;
}

template <typename Indices>
Alignment Align(const std::vector<PositionPair>& pairs, const Indices& indices) {
  std::vector<Eigen::Vector3d> in_map, in_world;
  for (const std::size_t i : indices) {
    in_map.push_back(pairs[i].in_map);
    in_world.push_back(pairs[i].in_world);
  }
  return AlignPoints(in_map, in_world, true);
}

Eigen::Vector3d Residual(const Sim3& world_from_map, const PositionPair& pair) {
  return world_from_map * pair.in_map - pair.in_world;
}

double SquaredDistance(const Eigen::Vector3d& residual, double sigma_horizontal,
                       double sigma_vertical) {
  const double horizontal = residual.head<2>().squaredNorm();
  return horizontal / (sigma_horizontal * sigma_horizontal) +
         residual.z() * residual.z() / (sigma_vertical * sigma_vertical);
}

double MedianDistance(const std::vector<PositionPair>& pairs, const Sim3& world_from_map,
                      double ratio, std::vector<double>* buffer) {
  buffer->clear();
  for (const auto& pair : pairs) {
    buffer->push_back(SquaredDistance(Residual(world_from_map, pair), 1.0, ratio));
  }
  return UpperMedian(buffer);
}

// The sample whose similarity leaves the least median distance; all pairs where no sample is
// usable.
Sim3 LeastMedian(const std::vector<PositionPair>& pairs, double ratio, std::uint64_t seed,
                 int samples) {
  std::vector<std::size_t> all(pairs.size());
  std::iota(all.begin(), all.end(), 0);
  Sim3 best = Align(pairs, all).target_from_source;
  std::vector<double> buffer;
  double least = MedianDistance(pairs, best, ratio, &buffer);
  for (const Triple& triple : Triples(pairs.size(), seed, samples)) {
    const Alignment sample = Align(pairs, triple);
    if (sample.rank < 2) continue;
    const double median = MedianDistance(pairs, sample.target_from_source, ratio, &buffer);
    if (median < least) {
      least = median;
      best = sample.target_from_source;
    }
  }
  return best;
}

class RobustFitter {
 public:
  RobustFitter(const std::vector<PositionPair>& pairs, const NoisePrior& prior)
      : pairs_(pairs), prior_(prior) {
    // Residuals of few pairs are smaller than the noise: the fit has seven parameters.
    const double numbers = 3.0 * static_cast<double>(pairs.size());
    small_sample_ = std::sqrt(numbers / (numbers - 7.0));
  }

  RobustFit Fit(const Sim3& start) {
    fit_.world_from_map = start;
    fit_.world_from_map = Align(pairs_, Near()).target_from_source;
    for (int round = 0; round < kRounds; ++round) {
      MeasureNoise();
      Step();
    }
    MeasureNoise();
    for (const auto& pair : pairs_) fit_.inlier.push_back(Distance(pair) < kGate);
    return fit_;
  }

 private:
  double Distance(const PositionPair& pair) const {
    return SquaredDistance(Residual(fit_.world_from_map, pair), fit_.sigma_horizontal,
                           fit_.sigma_vertical);
  }
  // The pairs that the sample explains, by a noise from its median.
  std::vector<std::size_t> Near() {
    const double ratio = prior_.vertical_ratio();
    std::vector<double> buffer;
    const double median = MedianDistance(pairs_, fit_.world_from_map, ratio, &buffer);
    fit_.sigma_horizontal = std::max(std::sqrt(median / kMedian3) * small_sample_,
                                     NoiseFloor(pairs_, fit_.world_from_map));
    fit_.sigma_vertical = ratio * fit_.sigma_horizontal;
    std::vector<std::size_t> near;
    for (std::size_t i = 0; i < pairs_.size(); ++i) {
      if (Distance(pairs_[i]) < kGate) near.push_back(i);
    }
    return near;
  }
  void MeasureNoise() {
    const double floor = NoiseFloor(pairs_, fit_.world_from_map);
    std::vector<double> all, horizontal, vertical;
    for (const auto& pair : pairs_) {
      const Eigen::Vector3d residual = Residual(fit_.world_from_map, pair);
      all.push_back(residual.squaredNorm());
      horizontal.push_back(residual.head<2>().squaredNorm());
      vertical.push_back(std::abs(residual.z()));
    }
    if (!prior_.vertical_differs) {
      const double sigma = std::max(std::sqrt(UpperMedian(&all) / kMedian3) * small_sample_, floor);
      fit_.sigma_horizontal = fit_.sigma_vertical = sigma;
      return;
    }
    fit_.sigma_horizontal =
        std::max(std::sqrt(UpperMedian(&horizontal) / kMedian2) * small_sample_, floor);
    const double measured =
        std::max(UpperMedian(&vertical) / kMedianMagnitude * small_sample_, floor);
    fit_.sigma_vertical = BlendedVertical(measured);
  }
  // The measured noise of the heights, held near the usual ratio as if by four more pairs.
  double BlendedVertical(double measured) const {
    constexpr double kPriorPairs = 4.0;
    const double n = static_cast<double>(pairs_.size());
    const double usual = prior_.vertical_ratio() * fit_.sigma_horizontal;
    return std::exp((n * std::log(measured) + kPriorPairs * std::log(usual)) / (n + kPriorPairs));
  }
  void Step() {
    const SimilarityRows rows(pairs_, fit_.world_from_map);
    const Eigen::Vector3d weights(std::pow(fit_.sigma_horizontal, -2),
                                  std::pow(fit_.sigma_horizontal, -2),
                                  std::pow(fit_.sigma_vertical, -2));
    Matrix7d normal = Matrix7d::Zero();
    Eigen::Matrix<double, 7, 1> right = Eigen::Matrix<double, 7, 1>::Zero();
    for (const auto& pair : pairs_) {
      const double cauchy = 1.0 / (1.0 + Distance(pair) / kCauchy);
      const auto row = rows.Of(pair);
      normal += row.jacobian.transpose() * (cauchy * weights).asDiagonal() * row.jacobian;
      right -= row.jacobian.transpose() * (cauchy * weights).asDiagonal() * row.residual;
    }
    Damp(&normal);
    fit_.world_from_map = rows.Moved(normal.ldlt().solve(right));
  }

  const std::vector<PositionPair>& pairs_;
  NoisePrior prior_;
  double small_sample_ = 1.0;
  RobustFit fit_;
};

}  // namespace

double NoiseFloor(const std::vector<PositionPair>& pairs, const Sim3& world_from_map) {
  constexpr double kRelative = 1e-9;
  const Eigen::Vector3d first = world_from_map * pairs.front().in_map;
  double extent = 0.0;
  for (const auto& pair : pairs) {
    extent = std::max(extent, (world_from_map * pair.in_map - first).norm());
  }
  return kRelative * extent + 1e-12;
}

RobustFit FitRobustly(const std::vector<PositionPair>& pairs, const NoisePrior& prior,
                      std::uint64_t seed, int samples) {
  return RobustFitter(pairs, prior).Fit(LeastMedian(pairs, prior.vertical_ratio(), seed, samples));
}

}  // namespace planegraph
