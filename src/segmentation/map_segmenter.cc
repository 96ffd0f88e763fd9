#include "planegraph/segmentation/map_segmenter.h"

#include <algorithm>
#include <cmath>
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

// All tiles, in the order in which points that are ever more densely spread over the cloud (van der
// Corput's sequence) meet them: full ones early, and those with a stray alone at the end.
std::vector<std::size_t> FullTilesFirst(const CloudTiles& tiles) {
  std::vector<double> ends;
  for (std::size_t t = 0; t < tiles.count(); ++t) {
    ends.push_back((ends.empty() ? 0.0 : ends.back()) + static_cast<double>(tiles.PointsOf(t)));
  }
  std::vector<std::size_t> order;
  std::vector<bool> met(tiles.count(), false);
  const auto meet = [&](std::size_t tile) {
    if (!met[tile]) order.push_back(tile);
    met[tile] = true;
  };
  for (std::size_t k = 1; k < 4 * tiles.count(); ++k) {
    double place = 0.0, share = 0.5;
    for (std::size_t bits = k; bits > 0; bits /= 2, share /= 2) place += share * (bits % 2);
    const auto end = std::upper_bound(ends.begin(), ends.end(), place * ends.back());
    meet(static_cast<std::size_t>(end - ends.begin()));
  }
  for (std::size_t t = 0; t < tiles.count(); ++t) meet(t);
  return order;
}

// The noise of the quietest surfaces, measured over a share of the tiles as one cloud.
NoiseModel MapNoise(const CloudTiles& tiles, const SegmentationOptions& options,
                    std::size_t enough_points) {
  constexpr std::size_t kEnoughSamples = 240;  // 30 for each bin that EstimateNoise makes
  std::vector<std::vector<NoiseSample>> samples(tiles.count());
  std::size_t points = 0, total = 0;
  for (const std::size_t t : FullTilesFirst(tiles)) {
    if (points >= enough_points && total >= kEnoughSamples) break;
    const Cloud tile = tiles.Load(t);
    samples[t] = CollectNoiseSamples(CellOctree(tile, options.cell_size, options.levels), tile,
                                     options.kind);
    points += tile.size();
    total += samples[t].size();
  }
  std::vector<NoiseSample> all;
  for (const auto& of_tile : samples) all.insert(all.end(), of_tile.begin(), of_tile.end());
  return EstimateNoise(std::move(all));
}

// Appends a tile's planes and patches to the whole; its labels become those of the whole.
void Append(Segmentation* tile, PlaneSet* whole) {
  const auto first = static_cast<std::int32_t>(whole->planes.size());
  for (PlaneSegment& plane : tile->planes.planes) {
    plane.id += first;
    whole->planes.push_back(std::move(plane));
  }
  for (Patch& patch : tile->planes.patches) {
    if (patch.segment >= 0) patch.segment += first;
    whole->patches.push_back(patch);
  }
  for (std::int32_t& label : tile->labels) label = label < 0 ? -1 : label + first;
  whole->viewpoint = tile->planes.viewpoint;
  whole->offset = tile->planes.offset;
  whole->point_count += tile->planes.point_count;
}

}  // namespace

DensitySample::DensitySample(std::size_t total) : stride_(1 + total / kThinned) {}

void DensitySample::Add(const Cloud& part) {
  const std::size_t first = (stride_ - seen_ % stride_) % stride_;
  for (std::size_t i = first; i < part.size(); i += stride_) points_.push_back(part.points[i]);
  seen_ += part.size();
}

double DensitySample::PerSquareMetre() const {
  if (points_.size() <= kProbeNeighbours) return 0.0;
  std::vector<double> distances;
  const std::size_t step = 1 + points_.size() / kProbes;
  for (std::size_t i = 0; i < points_.size(); i += step) {
    distances.push_back(DistanceToNeighbour(points_, points_[i]));
  }
  const double distance = Median(std::move(distances));
  const double area = std::numbers::pi * std::max(distance * distance, 1e-12);
  return static_cast<double>(stride_) * (kProbeNeighbours - 1) / area;
}

SegmentationOptions VisionOptions(const Cloud& cloud) {
  DensitySample sample(cloud.size());
  sample.Add(cloud);
  return VisionOptions(sample);
}

SegmentationOptions VisionOptions(const DensitySample& sample) {
  constexpr double kPointsPerCell = 9.0;
  SegmentationOptions options;
  options.kind = CloudKind::kVision;
  const double density = sample.PerSquareMetre();
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

PlaneSet SegmentTiles(const CloudTiles& tiles, const MapSegmentationOptions& options,
                      const TakeLabels& take) {
  SegmentationOptions segmentation = options.segmentation;
  if (!segmentation.noise) {
    segmentation.noise = MapNoise(tiles, segmentation, options.noise_points);
  }
  PlaneSet whole;
  whole.kind = segmentation.kind;
  whole.noise = *segmentation.noise;
  const std::size_t batch = 4 * static_cast<std::size_t>(ResolveThreads(options.threads));
  for (std::size_t first = 0; first < tiles.count(); first += batch) {
    std::vector<Segmentation> parts(std::min(batch, tiles.count() - first));
    ParallelFor(parts.size(), options.threads, [&](std::size_t k) {
      parts[k] = SegmentPlanes(tiles.Load(first + k), segmentation);
    });
    for (std::size_t k = 0; k < parts.size(); ++k) {
      Append(&parts[k], &whole);
      take(first + k, std::move(parts[k].labels));
    }
  }
  return whole;
}

Segmentation SegmentMap(const Cloud& cloud, const MapSegmentationOptions& options) {
  const TilesInMemory tiles(cloud, options.tile);
  Segmentation whole;
  whole.labels.assign(cloud.size(), -1);
  whole.planes = SegmentTiles(tiles, options, [&](std::size_t t, std::vector<std::int32_t> labels) {
    const auto& points = tiles.IndicesOf(t);
    for (std::size_t i = 0; i < points.size(); ++i) whole.labels[points[i]] = labels[i];
  });
  whole.noise = whole.planes.noise;
  whole.planes.offset = cloud.offset;
  whole.planes.viewpoint = cloud.viewpoint - cloud.offset;
  return whole;
}

}  // namespace planegraph
