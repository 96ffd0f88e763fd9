#include <array>
#include <cmath>
#include <cstdint>
#include <unordered_map>

#include "planegraph/base/error.h"
#include "planegraph/evaluation/map_quality.h"

namespace planegraph {
namespace {

// Neighbourhoods of points farther apart than two radii share nothing.
constexpr double kRadiiPerBlock = 10.0;

// The number of each point's cube, from 0 in the order of first occurrence.
std::vector<std::uint32_t> Cubes(const Cloud& cloud, double edge, std::size_t* count) {
  std::unordered_map<std::uint64_t, std::uint32_t> numbers;
  std::vector<std::uint32_t> cubes;
  cubes.reserve(cloud.size());
  for (const Eigen::Vector3f& p : cloud.points) {
    std::uint64_t key = 0;
    for (int axis = 0; axis < 3; ++axis) {
      const double cell = std::floor(static_cast<double>(p[axis]) / edge);
      key = (key << 21) ^ (static_cast<std::uint64_t>(static_cast<std::int64_t>(cell)) & 0x1FFFFF);
    }
    cubes.push_back(numbers.emplace(key, static_cast<std::uint32_t>(numbers.size())).first->second);
  }
  *count = numbers.size();
  return cubes;
}

std::array<double, 3> Figures(const PointQuality& point) {
  return {point.entropy, point.plane_variance, point.thickness};
}

// Sums per cube of the three figures that figures(i) gives for point i, without those that are NaN.
class CubeSums {
 public:
  template <typename FiguresOf>
  CubeSums(const Cloud& cloud, double radius, const FiguresOf& figures) {
    std::size_t count = 0;
    const auto cubes = Cubes(cloud, kRadiiPerBlock * radius, &count);
    for (auto& blocks : blocks_) blocks.resize(count);
    for (std::size_t i = 0; i < cubes.size(); ++i) {
      const std::array<double, 3> values = figures(i);
      for (std::size_t k = 0; k < 3; ++k) {
        if (!std::isfinite(values[k])) continue;
        blocks_[k][cubes[i]].sum += values[k];
        blocks_[k][cubes[i]].count += 1.0;
      }
    }
  }

  MapQualityIntervals Intervals(double level) const {
    MapQualityIntervals result;
    result.mme = MeanInterval(blocks_[0], level);
    result.mpv = MeanInterval(blocks_[1], level);
    result.thickness_mean = MeanInterval(blocks_[2], level);
    for (const BlockSum& block : blocks_[0]) result.blocks += block.count > 0.0 ? 1 : 0;
    return result;
  }
  BlockSum Total(std::size_t k) const {
    BlockSum total;
    for (const BlockSum& block : blocks_[k]) {
      total.sum += block.sum;
      total.count += block.count;
    }
    return total;
  }
  double Mean(std::size_t k) const {
    const BlockSum total = Total(k);
    return total.count > 0.0 ? total.sum / total.count : 0.0;
  }

 private:
  std::array<std::vector<BlockSum>, 3> blocks_;
};

}  // namespace

MapQualityIntervals ComputeIntervals(const Cloud& cloud, const MapQuality& quality,
                                     const MapQualityOptions& options, double level) {
  if (quality.values.size() != cloud.size() || options.mode == MapQualityMode::kTool) return {};
  const CubeSums sums(cloud, options.radius,
                      [&](std::size_t i) { return Figures(quality.values[i]); });
  return sums.Intervals(level);
}

MapQualityDifference CompareQuality(const Cloud& cloud_a, const MapQuality& a, const MapQuality& b,
                                    const MapQualityOptions& options, double level) {
  if (a.values.size() != cloud_a.size() || b.values.size() != a.values.size()) {
    throw UsageError("the clouds to compare are not of the same points");
  }
  const CubeSums sums(cloud_a, options.radius, [&](std::size_t i) {
    const auto of_a = Figures(a.values[i]), of_b = Figures(b.values[i]);
    return std::array<double, 3>{of_b[0] - of_a[0], of_b[1] - of_a[1], of_b[2] - of_a[2]};
  });
  MapQualityDifference result;
  result.points = static_cast<std::size_t>(sums.Total(0).count);
  if (result.points == 0) throw NoResultError("no point has a neighbourhood under both estimates");
  result.mme = sums.Mean(0);
  result.mpv = sums.Mean(1);
  result.thickness_mean = sums.Mean(2);
  result.intervals = sums.Intervals(level);
  return result;
}

}  // namespace planegraph
