#include "evaluation/local_plane.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <functional>

#include "planegraph/geometry/moments.h"

namespace planegraph {
namespace {

constexpr float kInlierDistance = 0.005f;
constexpr std::size_t kSample = 512;
constexpr int kMaxHypotheses = 50;
constexpr double kConfidence = 0.99;

// SplitMix64 (Steele et al. 2014): one addition and a hash per number.
std::uint64_t NextRandom(std::uint64_t* state) {
  std::uint64_t z = (*state += 0x9E3779B97F4A7C15ull);
  z = (z ^ (z >> 30)) * 0xBF58476D1CE4E5B9ull;
  z = (z ^ (z >> 27)) * 0x94D049BB133111EBull;
  return z ^ (z >> 31);
}

// Number of hypotheses after which one free of outliers was drawn with the wanted confidence.
double HypothesesNeeded(double inlier_share) {
  const double clean = inlier_share * inlier_share * inlier_share;
  if (clean >= 1.0) return 0.0;
  return std::log(1.0 - kConfidence) / std::log1p(-std::max(clean, 1e-9));
}

}  // namespace

PlaneVariance::PlaneVariance(const RadiusGrid& grid, std::uint64_t seed, bool as_tool)
    : grid_(grid), seed_(seed), as_tool_(as_tool) {}

double PlaneVariance::operator()(const Neighbourhood& neighbourhood) {
  if (neighbourhood.size() < 4) return -1.0;
  TakeSample(neighbourhood);
  const Hypothesis best = BestOfSample(neighbourhood);
  if (best.inliers < 3) return -1.0;
  Measure(neighbourhood, Refine(best));
  return MeanOfLargestQuarter();
}

// Every k-th neighbour: the order is that of the cells, so the sample is spread over all of them.
void PlaneVariance::TakeSample(const Neighbourhood& neighbourhood) {
  const std::size_t stride = as_tool_ ? 1 : (neighbourhood.size() + kSample - 1) / kSample;
  for (auto* axis : {&x_, &y_, &z_}) axis->clear();
  std::size_t next = 0, passed = 0;
  const auto take = [&](float x, float y, float z) {
    x_.push_back(x), y_.push_back(y), z_.push_back(z);
    next += stride;
  };
  const Eigen::Vector3f& centre = neighbourhood.centre;
  for (const auto& [begin, end] : neighbourhood.whole) {
    for (; next < passed + end - begin;) {
      const std::size_t i = begin + next - passed;
      take(grid_.x()[i] - centre.x(), grid_.y()[i] - centre.y(), grid_.z()[i] - centre.z());
    }
    passed += end - begin;
  }
  while (next < passed + neighbourhood.listed) {
    const std::size_t i = next - passed;
    take(neighbourhood.x[i], neighbourhood.y[i], neighbourhood.z[i]);
  }
}

PlaneVariance::Hypothesis PlaneVariance::Propose(std::uint64_t* state) const {
  std::size_t i[3];
  for (std::size_t& k : i) k = NextRandom(state) % x_.size();
  const auto point = [&](std::size_t k) { return Eigen::Vector3f(x_[k], y_[k], z_[k]); };
  const Eigen::Vector3f a = point(i[0]);
  const Eigen::Vector3f normal = (point(i[1]) - a).cross(point(i[2]) - a);
  const float length = normal.norm();
  if (!(length > 1e-12f)) return {{0, 0, 0}, 0, 0};
  const Eigen::Vector3f n = normal / length;
  Hypothesis plane{{n.x(), n.y(), n.z()}, n.dot(a), 0};
  plane.inliers = CountInliers(plane);
  return plane;
}

std::size_t PlaneVariance::CountInliers(const Hypothesis& plane) const {
  const float *n = plane.normal, *x = x_.data(), *y = y_.data(), *z = z_.data();
  int count = 0;
  for (std::size_t k = 0; k < x_.size(); ++k) {
    const float distance = n[0] * x[k] + n[1] * y[k] + n[2] * z[k] - plane.distance;
    count += std::abs(distance) <= kInlierDistance ? 1 : 0;
  }
  return static_cast<std::size_t>(count);
}

PlaneVariance::Hypothesis PlaneVariance::BestOfSample(const Neighbourhood& neighbourhood) const {
  std::uint64_t state = seed_ ^ (0xD1B54A32D192ED03ull * (neighbourhood.index + 1ull));
  Hypothesis best{{0, 0, 0}, 0, 0};
  double needed = kMaxHypotheses;
  for (int k = 0; k < kMaxHypotheses && k < needed; ++k) {
    const Hypothesis plane = Propose(&state);
    if (plane.inliers <= best.inliers) continue;
    best = plane;
    needed = HypothesesNeeded(static_cast<double>(best.inliers) / static_cast<double>(x_.size()));
  }
  return best;
}

PlaneVariance::Hypothesis PlaneVariance::Refine(const Hypothesis& plane) const {
  const float* n = plane.normal;
  RawMoments moments;
  for (std::size_t k = 0; k < x_.size(); ++k) {
    const float distance = n[0] * x_[k] + n[1] * y_[k] + n[2] * z_[k] - plane.distance;
    if (std::abs(distance) <= kInlierDistance) moments.Add(x_[k], y_[k], z_[k]);
  }
  const Eigen::Vector3d normal = ComputePrincipalAxes(moments.Covariance()).vectors.col(0);
  const Eigen::Vector3f f = normal.cast<float>();
  return {{f.x(), f.y(), f.z()},
          static_cast<float>(normal.dot(moments.Mean())),
          static_cast<std::size_t>(moments.count)};
}

void PlaneVariance::Measure(const Neighbourhood& neighbourhood, const Hypothesis& plane) {
  distances_.resize(neighbourhood.size());
  const float *n = plane.normal, *x = grid_.x().data(), *y = grid_.y().data(),
              *z = grid_.z().data();
  const Eigen::Vector3f& c = neighbourhood.centre;
  float* out = distances_.data();
  for (const auto& [begin, end] : neighbourhood.whole) {
    for (std::uint32_t k = begin; k < end; ++k) {
      const float dx = x[k] - c.x(), dy = y[k] - c.y(), dz = z[k] - c.z();
      *out++ = std::abs(n[0] * dx + n[1] * dy + n[2] * dz - plane.distance);
    }
  }
  x = neighbourhood.x.data(), y = neighbourhood.y.data(), z = neighbourhood.z.data();
  for (std::size_t k = 0; k < neighbourhood.listed; ++k) {
    *out++ = std::abs(n[0] * x[k] + n[1] * y[k] + n[2] * z[k] - plane.distance);
  }
}

double PlaneVariance::MeanOfLargestQuarter() {
  const std::size_t count = distances_.size(), floor_quarter = count / 4;
  const std::size_t largest = as_tool_ ? count - 3 * floor_quarter : (count + 3) / 4;
  return SumOfLargest(largest) / static_cast<double>(as_tool_ ? floor_quarter : largest);
}

// Selection by partitioning costs more than all the rest here, for no branch can be predicted. The
// leading bits of a float that is not negative sort like the float: a histogram of them finds the
// bin in which the last value wanted lies, and only that bin is partitioned.
double PlaneVariance::SumOfLargest(std::size_t largest) {
  constexpr int kShift = 21;  // of 31 bits: the exponent and two bits behind it
  const auto bin = [](float value) { return std::bit_cast<std::uint32_t>(value) >> kShift; };
  const auto lower_end = [](std::size_t b) {
    return std::bit_cast<float>(static_cast<std::uint32_t>(b) << kShift);
  };
  // Two counters a bin in turns: the processor need not wait for the one before.
  bins_.assign(std::size_t{2} << (31 - kShift), 0);
  std::uint32_t turn = 0;
  for (const float d : distances_) ++bins_[2 * bin(d) + (turn++ & 1)];
  std::size_t last = bins_.size() / 2 - 1, above = 0;
  const auto in_bin = [&](std::size_t b) { return bins_[2 * b] + bins_[2 * b + 1]; };
  while (above + in_bin(last) < largest) above += in_bin(last--);
  edge_.resize(in_bin(last) + 1);  // one to spare: all are written, those of the bin kept
  std::size_t kept = 0;
  for (const float d : distances_) {
    edge_[kept] = d;
    kept += bin(d) == last ? 1 : 0;
  }
  const auto middle = edge_.begin() + static_cast<std::ptrdiff_t>(largest - above) - 1;
  std::nth_element(edge_.begin(), middle, edge_.end() - 1, std::greater<>());
  double sum = above > 0 ? SumFrom(lower_end(last + 1), above) : 0.0;
  for (auto value = edge_.begin(); value <= middle; ++value) sum += *value;
  return sum;
}

// The sum of the `count` distances that are at least `low`; floats by blocks, which vectors add.
double PlaneVariance::SumFrom(float low, std::size_t count) const {
  constexpr Eigen::Index kBlock = 1024;
  const Eigen::Map<const Eigen::ArrayXf> all(distances_.data(),
                                             static_cast<Eigen::Index>(distances_.size()));
  double excess = 0.0;
  for (Eigen::Index k = 0; k < all.size(); k += kBlock) {
    excess += (all.segment(k, std::min(kBlock, all.size() - k)) - low).max(0.0f).sum();
  }
  return excess + static_cast<double>(count) * static_cast<double>(low);
}

}  // namespace planegraph
