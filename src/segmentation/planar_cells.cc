#include "segmentation/planar_cells.h"

#include <cmath>
#include <numbers>

namespace planegraph {
namespace {

constexpr std::uint32_t kLeastPoints = 5;

struct Splitter {
  const CellOctree& octree;
  const Cloud& cloud;
  const NoiseModel& noise;
  const SegmentationOptions& options;
  CellSplit split;

  bool TryPlanar(int level, std::uint32_t index);
  double ExpectedNoise(const Sighting& seen, const PrincipalAxes& axes, double count) const;
  Orientation Turn(const CellOctree::Cell& cell, const Eigen::Vector3d& mean,
                   Eigen::Vector3d* normal) const;
  void Visit(int level, std::uint32_t index);
  void Mark(int level, std::uint32_t index, std::int32_t owner);
};

bool Splitter::TryPlanar(int level, std::uint32_t index) {
  if (octree.Level(level)[index].point_count < kLeastPoints) return false;
  const CellSums sums = octree.Sums(level, index);
  const Moments moments = sums.ToMoments();
  const PrincipalAxes axes = ComputePrincipalAxes(moments.scatter);
  const Sighting seen(cloud, options.kind, moments.mean, axes.vectors.col(0));
  const double sigma = ExpectedNoise(seen, axes, sums.count);
  if (!IsPlanar(axes.values[0], sums.count, sigma, options.planarity)) return false;
  if (!SpansPlane(axes, sums.count, sigma)) return false;
  const double tilt = sigma / std::sqrt(std::max(axes.values[1], 1e-300));
  if (tilt > options.max_tilt_deg * std::numbers::pi / 180.0) return false;
  Eigen::Vector3d normal = axes.vectors.col(0);
  const Orientation orientation = Turn(octree.Level(level)[index], moments.mean, &normal);
  split.planar.push_back(
      {level, index, moments.mean, normal, sums.count, sigma, tilt, orientation});
  return true;
}

// The noise of photogrammetry changes with texture and distance from place to place: what a flat
// cell shows itself counts, up to what the rougher cells of the cloud have.
double Splitter::ExpectedNoise(const Sighting& seen, const PrincipalAxes& axes,
                               double count) const {
  const double model = noise.AlongNormal(seen.range, seen.cosine);
  if (options.kind == CloudKind::kLaser) return model;
  constexpr double kMostRoughness = 4.0;  // times the quietest surfaces
  const double own = std::sqrt(std::max(axes.values[0], 0.0) / std::max(count - 3.0, 1.0));
  return std::clamp(own, model, kMostRoughness * model);
}

// Turns the normal to the side that the points were seen from: the scanner's, or that of most of
// the points' own normals.
Orientation Splitter::Turn(const CellOctree::Cell& cell, const Eigen::Vector3d& mean,
                           Eigen::Vector3d* normal) const {
  constexpr double kMajority = 0.5;  // of the points' normals, net
  double facing = normal->dot(cloud.viewpoint - cloud.offset - mean);
  if (options.kind == CloudKind::kVision) {
    facing = 0.0;
    for (std::uint32_t i = 0; i < cell.point_count && !cloud.normals.empty(); ++i) {
      const auto& own = cloud.normals[octree.order()[cell.first_point + i]];
      facing += own.cast<double>().dot(*normal) > 0.0 ? 1.0 : -1.0;
    }
    if (std::abs(facing) < kMajority * cell.point_count) return Orientation::kUnknown;
  }
  if (facing < 0.0) *normal = -*normal;
  return Orientation::kSensor;
}

void Splitter::Mark(int level, std::uint32_t index, std::int32_t owner) {
  split.owner[level][index] = owner;
  if (level == 0) return;
  const auto& cell = octree.Level(level)[index];
  for (std::uint32_t k = 0; k < cell.child_count; ++k) Mark(level - 1, cell.first_child + k, owner);
}

void Splitter::Visit(int level, std::uint32_t index) {
  if (TryPlanar(level, index)) {
    return Mark(level, index, static_cast<std::int32_t>(split.planar.size() - 1));
  }
  if (level == 0) {
    split.owner[0][index] = CellSplit::kRough;
    return;
  }
  split.owner[level][index] = CellSplit::kSplit;
  const auto& cell = octree.Level(level)[index];
  for (std::uint32_t k = 0; k < cell.child_count; ++k) Visit(level - 1, cell.first_child + k);
}

}  // namespace

Sighting::Sighting(const Cloud& cloud, CloudKind kind, const Eigen::Vector3d& point,
                   const Eigen::Vector3d& normal) {
  if (kind == CloudKind::kVision) return;
  const Eigen::Vector3d beam = point + cloud.offset - cloud.viewpoint;
  range = beam.norm();
  cosine = range > 0 ? std::abs(normal.dot(beam)) / range : 1.0;
}

bool SpansPlane(const PrincipalAxes& axes, double count, double sigma) {
  constexpr double kLeastAspect = 0.01;  // squared: the narrow side is a tenth of the long one
  constexpr double kLeastSpread = 9.0;   // squared: three standard deviations of the noise
  return axes.values[1] > kLeastAspect * axes.values[2] &&
         axes.values[1] > kLeastSpread * sigma * sigma * count;
}

bool IsPlanar(double smallest_eigenvalue, double count, double sigma, double planarity) {
  // Mean of chi-square with count - 3 degrees of freedom, plus three of its standard deviations.
  const double freedom = std::max(count - 3.0, 1.0);
  const double slack = 1.0 + 3.0 * std::sqrt(2.0 / freedom);
  return smallest_eigenvalue / freedom <= planarity * planarity * sigma * sigma * slack;
}

std::vector<NoiseSample> CollectNoiseSamples(const CellOctree& octree, const Cloud& cloud,
                                             CloudKind kind) {
  // Cells well above the noise and well below the objects; enough points for a variance.
  const int wanted = kind == CloudKind::kLaser ? 2 : 1;
  constexpr std::uint32_t kEnough = 12;
  constexpr double kNotALine = 0.1;
  std::vector<NoiseSample> samples;
  const int level = std::min(wanted, octree.levels() - 1);
  const auto& cells = octree.Level(level);
  for (std::uint32_t i = 0; i < cells.size(); ++i) {
    if (cells[i].point_count < kEnough) continue;
    const Moments moments = octree.Sums(level, i).ToMoments();
    const PrincipalAxes axes = ComputePrincipalAxes(moments.scatter);
    const double variance = axes.values[0] / (moments.count - 3.0);
    // No plane at all: edges, clutter, a single scan line.
    if (!SpansPlane(axes, moments.count, std::sqrt(variance))) continue;
    if (axes.values[1] < kNotALine * axes.values[2]) continue;
    const Sighting seen(cloud, kind, moments.mean, axes.vectors.col(0));
    if (seen.cosine < NoiseModel::kLeastCosine) continue;
    samples.push_back({seen.range, variance / (seen.cosine * seen.cosine)});
  }
  return samples;
}

CellSplit SplitIntoPlanarCells(const CellOctree& octree, const Cloud& cloud,
                               const NoiseModel& noise, const SegmentationOptions& options) {
  Splitter splitter{octree, cloud, noise, options, {}};
  for (int level = 0; level < octree.levels(); ++level) {
    splitter.split.owner.emplace_back(octree.Level(level).size(), CellSplit::kSplit);
  }
  const int top = octree.levels() - 1;
  for (std::uint32_t i = 0; i < octree.Level(top).size(); ++i) splitter.Visit(top, i);
  return std::move(splitter.split);
}

}  // namespace planegraph
