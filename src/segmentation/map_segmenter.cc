#include "planegraph/segmentation/map_segmenter.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>

#include "planegraph/base/median.h"
#include "planegraph/base/parallel.h"
#include "segmentation/planar_cells.h"

namespace planegraph {
namespace {

constexpr std::size_t kProbes = 128, kProbeNeighbours = 9;
constexpr std::size_t kThinned = 300000;  // points that are looked at for the density

double DistanceToNeighbour(const std::vector<Eigen::Vector3f>& points, const Eigen::Vector3f& at) {
  std::vector<float> nearest(kProbeNeighbours, INFINITY);  // a heap, farthest first
  for (const auto& p : points) {
    const float square = (p - at).squaredNorm();
    if (square >= nearest.front()) continue;
    std::pop_heap(nearest.begin(), nearest.end());
    nearest.back() = square;
    std::push_heap(nearest.begin(), nearest.end());
  }
  return std::sqrt(static_cast<double>(nearest.front()));
}

// Points per square metre of surface: the median over a few places.
double SurfaceDensity(const Cloud& cloud) {
  const std::size_t stride = 1 + cloud.size() / kThinned;
  std::vector<Eigen::Vector3f> thinned;
  for (std::size_t i = 0; i < cloud.size(); i += stride) thinned.push_back(cloud.points[i]);
  if (thinned.size() <= kProbeNeighbours) return 0.0;
  std::vector<double> distances;
  const std::size_t step = 1 + thinned.size() / kProbes;
  for (std::size_t i = 0; i < thinned.size(); i += step) {
    distances.push_back(DistanceToNeighbour(thinned, thinned[i]));
  }
  const double distance = Median(std::move(distances));
  const double area = std::numbers::pi * std::max(distance * distance, 1e-12);
  return static_cast<double>(stride) * (kProbeNeighbours - 1) / area;
}

using Tiles = std::vector<std::vector<std::uint32_t>>;

// The points of each tile that has any, tiles in order.
Tiles SplitIntoTiles(const Cloud& cloud, double edge) {
  std::map<std::pair<long, long>, std::vector<std::uint32_t>> tiles;
  for (std::uint32_t i = 0; i < cloud.size(); ++i) {
    const auto& p = cloud.points[i];
    tiles[{std::lround(std::floor(p.x() / edge)), std::lround(std::floor(p.y() / edge))}].push_back(
        i);
  }
  Tiles list;
  for (auto& [key, points] : tiles) list.push_back(std::move(points));
  return list;
}

// The noise of the quietest surfaces, measured over a share of the tiles as one cloud.
NoiseModel MapNoise(const Cloud& cloud, const Tiles& tiles, const SegmentationOptions& options) {
  constexpr std::size_t kEnough = 2000000;
  std::vector<NoiseSample> samples;
  std::size_t total = 0;
  const std::size_t stride = 1 + cloud.size() / kEnough;
  for (std::size_t t = 0; t < tiles.size() && total < kEnough; t += stride) {
    const Cloud tile = Select(cloud, tiles[t]);
    const auto more = CollectNoiseSamples(CellOctree(tile, options.cell_size, options.levels), tile,
                                          options.kind);
    samples.insert(samples.end(), more.begin(), more.end());
    total += tile.size();
  }
  return EstimateNoise(std::move(samples));
}

// Appends a tile's planes, patches and labels to the whole.
void Append(Segmentation tile, const std::vector<std::uint32_t>& points, Segmentation* whole) {
  const auto first = static_cast<std::int32_t>(whole->planes.planes.size());
  for (PlaneSegment& plane : tile.planes.planes) {
    plane.id += first;
    whole->planes.planes.push_back(std::move(plane));
  }
  for (Patch& patch : tile.planes.patches) {
    if (patch.segment >= 0) patch.segment += first;
    whole->planes.patches.push_back(patch);
  }
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (tile.labels[i] >= 0) whole->labels[points[i]] = tile.labels[i] + first;
  }
}

}  // namespace

SegmentationOptions VisionOptions(const Cloud& cloud) {
  constexpr double kPointsPerCell = 9.0;
  SegmentationOptions options;
  options.kind = CloudKind::kVision;
  const double density = SurfaceDensity(cloud);
  const double edge = density > 0.0 ? std::sqrt(kPointsPerCell / density) : 0.4;
  options.cell_size = std::clamp(edge, 0.1, 0.5);
  options.levels = 3;
  options.min_points = 30;
  options.min_area = 0.5;
  options.mask_cell_size = 0.5;
  options.correlation_length = 0.5;
  options.floor_offset = 0.03;
  options.floor_tilt_deg = 0.5;
  return options;
}

Segmentation SegmentMap(const Cloud& cloud, const MapSegmentationOptions& options) {
  const Tiles tiles = SplitIntoTiles(cloud, options.tile);
  SegmentationOptions segmentation = options.segmentation;
  if (!segmentation.noise) segmentation.noise = MapNoise(cloud, tiles, segmentation);
  Segmentation whole;
  whole.noise = *segmentation.noise;
  whole.labels.assign(cloud.size(), -1);
  whole.planes.kind = segmentation.kind;
  whole.planes.offset = cloud.offset;
  whole.planes.viewpoint = cloud.viewpoint - cloud.offset;
  whole.planes.point_count = cloud.size();
  whole.planes.noise = whole.noise;
  std::vector<Segmentation> parts(tiles.size());
  ParallelFor(tiles.size(), options.threads, [&](std::size_t t) {
    parts[t] = SegmentPlanes(Select(cloud, tiles[t]), segmentation);
  });
  for (std::size_t t = 0; t < tiles.size(); ++t) Append(std::move(parts[t]), tiles[t], &whole);
  return whole;
}

}  // namespace planegraph
