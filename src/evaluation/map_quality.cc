#include "planegraph/evaluation/map_quality.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "evaluation/local_plane.h"
#include "evaluation/radius_grid.h"
#include "planegraph/base/error.h"
#include "planegraph/base/parallel.h"
#include "planegraph/geometry/moments.h"

namespace planegraph {
namespace {

// Smallest variance, m^2, of a neighbourhood that has a volume.
constexpr double kLeastVariance = 1e-12;
// Points per chunk. Sums are taken per chunk and then in order, so threads do not change them.
constexpr std::size_t kChunk = 4096;
constexpr float kNothing = std::numeric_limits<float>::quiet_NaN();

struct ChunkSums {
  double entropy = 0.0, plane_variance = 0.0;
  std::size_t evaluated = 0, used = 0, mpv_failed = 0;
  std::vector<float> thickness;
};

// Bounds of cells whose chunks hold about kChunk points each.
std::vector<std::size_t> ChunkBounds(const RadiusGrid& grid) {
  std::vector<std::size_t> bounds{0};
  const auto& cells = grid.cells();
  for (std::size_t c = 1; c < grid.cell_count(); ++c) {
    if (cells[c].begin - cells[bounds.back()].begin >= kChunk) bounds.push_back(c);
  }
  bounds.push_back(grid.cell_count());
  return bounds;
}

class Evaluator {
 public:
  // `values`: null, or one per point of the cloud.
  Evaluator(const RadiusGrid& grid, const MapQualityOptions& options, PointQuality* values)
      : grid_(grid),
        options_(options),
        values_(values),
        variance_(grid, options.seed, options.mode == MapQualityMode::kTool) {}

  ChunkSums Run(std::size_t first, std::size_t last) {
    RadiusSweep sweep(grid_, first);
    for (std::size_t c = first; c < last; ++c) {
      bool moved = false;
      for (std::uint32_t i = grid_.cells()[c].begin; i < grid_.cells()[c + 1].begin; ++i) {
        if (grid_.order()[i] % options_.every != 0) continue;
        if (!moved) sweep.MoveTo(c);
        moved = true;
        sweep.Find(i, &neighbourhood_);
        Evaluate();
      }
    }
    return std::move(sums_);
  }

 private:
  void Evaluate() {
    ++sums_.evaluated;
    const bool tool = options_.mode == MapQualityMode::kTool;
    if (!tool && neighbourhood_.size() < options_.min_neighbours) return;
    const Eigen::Matrix3d covariance = neighbourhood_.moments.Covariance();
    const double smallest = ComputePrincipalAxes(covariance).values[0];
    const double determinant = covariance.determinant();
    if (tool ? !(determinant > 0.0) : !(smallest > kLeastVariance)) return;
    const double scale = 2.0 * std::numbers::pi * std::numbers::e;
    const double entropy = 0.5 * std::log(scale * scale * scale * determinant);
    const double variance = options_.plane_variance ? variance_(neighbourhood_) : 0.0;
    Add(entropy, variance, std::sqrt(smallest));
  }

  // `variance`: negative where no plane was found.
  void Add(double entropy, double variance, double thickness) {
    ++sums_.used;
    sums_.entropy += entropy;
    sums_.thickness.push_back(static_cast<float>(thickness));
    sums_.plane_variance += std::max(0.0, variance);
    sums_.mpv_failed += variance < 0.0 ? 1 : 0;
    if (!values_) return;
    values_[neighbourhood_.index] = {static_cast<float>(entropy),
                                     variance < 0.0 ? kNothing : static_cast<float>(variance),
                                     static_cast<float>(thickness)};
  }

  const RadiusGrid& grid_;
  const MapQualityOptions& options_;
  PointQuality* values_;
  PlaneVariance variance_;
  Neighbourhood neighbourhood_;
  ChunkSums sums_;
};

float MedianOf(std::vector<float>* values) {
  const auto half = values->begin() + static_cast<std::ptrdiff_t>(values->size() / 2);
  std::nth_element(values->begin(), half, values->end());
  if (values->size() % 2 == 1) return *half;
  return 0.5f * (*half + *std::max_element(values->begin(), half));
}

MapQuality Combine(const std::vector<ChunkSums>& chunks, std::size_t points,
                   const MapQualityOptions& options) {
  MapQuality result;
  result.points = points;
  std::vector<float> thickness;
  for (const ChunkSums& chunk : chunks) {
    result.mme += chunk.entropy;
    result.mpv += chunk.plane_variance;
    result.evaluated += chunk.evaluated;
    result.used += chunk.used;
    result.mpv_failed += chunk.mpv_failed;
    for (float t : chunk.thickness) result.thickness_mean += t;
    thickness.insert(thickness.end(), chunk.thickness.begin(), chunk.thickness.end());
  }
  if (result.used == 0) {
    throw NoResultError("no neighbourhood has enough points: take a larger radius");
  }
  result.failed = result.evaluated - result.used;
  const bool tool = options.mode == MapQualityMode::kTool;
  const std::size_t tool_count = std::max<std::size_t>(1, points / options.every);
  const auto divisor = static_cast<double>(tool ? tool_count : result.used);
  const std::size_t planes = result.used - result.mpv_failed;
  result.mme /= divisor;
  result.mpv /= tool ? divisor : static_cast<double>(std::max<std::size_t>(1, planes));
  result.thickness_mean /= static_cast<double>(result.used);
  result.thickness_median = MedianOf(&thickness);
  return result;
}

}  // namespace

MapQualityMode ParseMapQualityMode(const std::string& name) {
  if (name == "clean") return MapQualityMode::kClean;
  if (name == "tool") return MapQualityMode::kTool;
  throw UsageError("unknown mode '" + name + "' (clean or tool)");
}

std::string Name(MapQualityMode mode) { return mode == MapQualityMode::kClean ? "clean" : "tool"; }

MapQuality ComputeMapQuality(const Cloud& cloud, const MapQualityOptions& options) {
  if (options.every == 0) throw UsageError("every must be at least 1");
  const RadiusGrid grid(cloud.points, options.radius);
  const std::vector<std::size_t> bounds = ChunkBounds(grid);
  std::vector<ChunkSums> chunks(bounds.size() - 1);
  std::vector<PointQuality> values;
  if (options.keep_values) values.assign(cloud.size(), {kNothing, kNothing, kNothing});
  PointQuality* const kept = options.keep_values ? values.data() : nullptr;
  ParallelFor(chunks.size(), options.threads, [&](std::size_t k) {
    chunks[k] = Evaluator(grid, options, kept).Run(bounds[k], bounds[k + 1]);
  });
  MapQuality result = Combine(chunks, cloud.size(), options);
  result.values = std::move(values);
  return result;
}

}  // namespace planegraph
