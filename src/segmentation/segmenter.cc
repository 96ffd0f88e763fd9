#include "planegraph/segmentation/segmenter.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "segmentation/planar_cells.h"
#include "segmentation/region_growing.h"
#include "segmentation/segment_builder.h"

namespace planegraph {
namespace {

// Boundary points look for planes in the 27 cells of this level about them: two finest edges.
constexpr int kBoundaryLevel = 1;

// One run of the segmentation: its steps in order.
class Segmenter {
 public:
  Segmenter(const Cloud& cloud, const SegmentationOptions& options)
      : cloud_(cloud),
        options_(options),
        octree_(cloud, options.cell_size, options.levels),
        noise_(options.noise ? *options.noise
                             : EstimateNoise(CollectNoiseSamples(octree_, cloud, options.kind))),
        split_(SplitIntoPlanarCells(octree_, cloud, noise_, options)) {}

  Segmentation Run();

 private:
  void KeepLargeRegions();
  Plane PlaneOf(const Region& region) const;
  Orientation OrientationOf(const Region& region) const;
  void LabelPlanarCells();
  void LabelBoundaryPoints();
  void CollectSegments(std::uint32_t index, std::vector<std::int32_t>* found) const;
  std::vector<std::int32_t> SegmentsAround(std::uint32_t index) const;
  bool IsRough(std::uint32_t finest) const;
  void LabelRoughPoints(std::uint32_t first, std::uint32_t count,
                        const std::vector<std::int32_t>& near);
  void BuildSegments();
  void CollectPatches();

  const Cloud& cloud_;
  const SegmentationOptions& options_;
  CellOctree octree_;
  NoiseModel noise_;
  CellSplit split_;
  std::vector<Region> regions_;
  std::vector<std::int32_t> segment_of_cell_;  // planar cell -> segment
  std::vector<std::int32_t> sorted_labels_;    // by the octree's point order
  std::vector<Plane> planes_;                  // by segment
  Segmentation result_;
};

void Segmenter::KeepLargeRegions() {
  std::erase_if(regions_,
                [&](const Region& region) { return region.sums.count < options_.min_points; });
  segment_of_cell_.assign(split_.planar.size(), -1);
  for (std::size_t s = 0; s < regions_.size(); ++s) {
    for (const std::uint32_t cell : regions_[s].cells) {
      segment_of_cell_[cell] = static_cast<std::int32_t>(s);
    }
    planes_.push_back(PlaneOf(regions_[s]));
  }
}

// A region faces where most of its cells do.
Plane Segmenter::PlaneOf(const Region& region) const {
  const Plane plane = LeastSquaresPlane(region.sums.ToMoments(), cloud_.viewpoint - cloud_.offset);
  if (options_.kind == CloudKind::kLaser) return plane;
  double facing = 0.0;
  for (const std::uint32_t cell : region.cells) {
    const PlanarCell& planar = split_.planar[cell];
    if (planar.orientation == Orientation::kUnknown) continue;
    facing += planar.count * (planar.normal.dot(plane.normal) > 0.0 ? 1.0 : -1.0);
  }
  return facing < 0.0 ? plane.Flipped() : plane;
}

Orientation Segmenter::OrientationOf(const Region& region) const {
  double known = 0.0;
  for (const std::uint32_t cell : region.cells) {
    const PlanarCell& planar = split_.planar[cell];
    known += planar.orientation == Orientation::kSensor ? planar.count : 0.0;
  }
  return 2.0 * known > region.sums.count ? Orientation::kSensor : Orientation::kUnknown;
}

void Segmenter::LabelPlanarCells() {
  sorted_labels_.assign(cloud_.size(), -1);
  for (std::size_t c = 0; c < split_.planar.size(); ++c) {
    const PlanarCell& planar = split_.planar[c];
    const auto& cell = octree_.Level(planar.level)[planar.index];
    std::fill_n(sorted_labels_.begin() + cell.first_point, cell.point_count, segment_of_cell_[c]);
  }
}

void AddUnique(std::int32_t segment, std::vector<std::int32_t>* list) {
  if (segment < 0) return;
  if (std::find(list->begin(), list->end(), segment) == list->end()) list->push_back(segment);
}

// The segments with a planar cell in, or around, a cell of the level that boundary points are
// gathered by.
void Segmenter::CollectSegments(std::uint32_t index, std::vector<std::int32_t>* found) const {
  const std::int32_t owner = split_.owner[kBoundaryLevel][index];
  if (owner >= 0) return AddUnique(segment_of_cell_[owner], found);
  const auto& cell = octree_.Level(kBoundaryLevel)[index];
  for (std::uint32_t k = 0; k < cell.child_count; ++k) {
    const std::int32_t child = split_.owner[kBoundaryLevel - 1][cell.first_child + k];
    if (child >= 0) AddUnique(segment_of_cell_[child], found);
  }
}

std::vector<std::int32_t> Segmenter::SegmentsAround(std::uint32_t index) const {
  std::vector<std::int32_t> found;
  const NeighbourKeys keys(octree_.Level(kBoundaryLevel)[index].key);
  for (int k = 0; k < 27; ++k) {
    const int cell = octree_.Find(kBoundaryLevel, keys.At(k));
    if (cell >= 0) CollectSegments(static_cast<std::uint32_t>(cell), &found);
  }
  return found;
}

// Points at the border of planes: each goes to the nearest plane about its cell, where the noise
// allows it.
void Segmenter::LabelRoughPoints(std::uint32_t first, std::uint32_t count,
                                 const std::vector<std::int32_t>& near) {
  constexpr double kGate = 2.5;
  for (std::uint32_t i = first; i < first + count; ++i) {
    const Eigen::Vector3d point = octree_.sorted_points()[i].cast<double>();
    const double range = (point + cloud_.offset - cloud_.viewpoint).norm();
    // The noise is below the sum of its parts, so most planes are out before it is known exactly.
    const double farthest = 1.001 * kGate * (noise_.AlongBeam(range) + NoiseModel::kSurface);
    double best = kGate;
    for (const std::int32_t s : near) {
      const double metres = std::abs(planes_[s].SignedDistance(point));
      if (metres > farthest) continue;
      const Sighting seen(cloud_, options_.kind, point, planes_[s].normal);
      const double distance = metres / noise_.AlongNormal(seen.range, seen.cosine);
      if (distance < best) best = distance, sorted_labels_[i] = s;
    }
  }
}

bool Segmenter::IsRough(std::uint32_t finest) const {
  const std::int32_t owner = split_.owner[0][finest];
  return owner == CellSplit::kRough || (owner >= 0 && segment_of_cell_[owner] < 0);
}

void Segmenter::LabelBoundaryPoints() {
  const auto& cells = octree_.Level(kBoundaryLevel);
  for (std::uint32_t c = 0; c < cells.size(); ++c) {
    std::optional<std::vector<std::int32_t>> near;  // looked up once for all finest cells in it
    for (std::uint32_t k = cells[c].first_child; k < cells[c].first_child + cells[c].child_count;
         ++k) {
      if (!IsRough(k)) continue;
      if (!near) near = SegmentsAround(c);
      if (near->empty()) break;
      LabelRoughPoints(octree_.Level(0)[k].first_point, octree_.Level(0)[k].point_count, *near);
    }
  }
}

void Segmenter::BuildSegments() {
  std::vector<std::vector<std::uint32_t>> members(regions_.size());
  for (std::size_t s = 0; s < regions_.size(); ++s) {
    members[s].reserve(static_cast<std::size_t>(regions_[s].sums.count));
  }
  for (std::uint32_t i = 0; i < sorted_labels_.size(); ++i) {
    if (sorted_labels_[i] >= 0) members[sorted_labels_[i]].push_back(i);
  }
  std::vector<std::int32_t> new_id(regions_.size(), -1);
  for (std::size_t s = 0; s < regions_.size(); ++s) {
    PlaneSegment segment =
        BuildSegment(regions_[s], planes_[s], octree_.sorted_points(), members[s], options_);
    if (segment.area < options_.min_area) continue;
    segment.orientation = OrientationOf(regions_[s]);
    segment.id = new_id[s] = static_cast<std::int32_t>(result_.planes.planes.size());
    result_.planes.planes.push_back(std::move(segment));
  }
  for (auto& label : sorted_labels_) label = label < 0 ? -1 : new_id[label];
  for (auto& segment : segment_of_cell_) segment = segment < 0 ? -1 : new_id[segment];
}

void Segmenter::CollectPatches() {
  result_.planes.patches.reserve(split_.planar.size());
  for (std::size_t c = 0; c < split_.planar.size(); ++c) {
    const PlanarCell& cell = split_.planar[c];
    result_.planes.patches.push_back({octree_.Sums(cell.level, cell.index).ToMoments(), cell.normal,
                                      octree_.CellSize(cell.level), cell.sigma, segment_of_cell_[c],
                                      cell.orientation});
  }
}

Segmentation Segmenter::Run() {
  regions_ = GrowRegions(octree_, split_, FindNeighbours(octree_, split_), options_.planarity);
  KeepLargeRegions();
  LabelPlanarCells();
  LabelBoundaryPoints();
  BuildSegments();
  CollectPatches();
  result_.noise = noise_;
  PlaneSet& set = result_.planes;
  set.kind = options_.kind;
  set.offset = cloud_.offset;
  set.viewpoint = cloud_.viewpoint - cloud_.offset;
  set.point_count = cloud_.size();
  set.noise = noise_;
  if (options_.kind == CloudKind::kLaser) set.range_image = RangeImage(cloud_);
  result_.labels.assign(cloud_.size(), -1);
  for (std::size_t i = 0; i < sorted_labels_.size(); ++i) {
    result_.labels[octree_.order()[i]] = sorted_labels_[i];
  }
  return std::move(result_);
}

}  // namespace

Segmentation SegmentPlanes(const Cloud& cloud, const SegmentationOptions& options) {
  return Segmenter(cloud, options).Run();
}

}  // namespace planegraph
