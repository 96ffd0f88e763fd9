#include "segmentation/region_growing.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>

#include "planegraph/base/angles.h"

namespace planegraph {
namespace {

constexpr std::uint32_t kNone = 0xffffffffu;
// A region is fitted again when it has grown by this share.
constexpr double kRefit = 1.05;

// A plane with what its points say of its own uncertainty.
struct FittedPlane {
  Eigen::Vector3d mean, normal, axis1, axis2;
  double count, lambda1, lambda2, residual;

  explicit FittedPlane(const CellSums& sums) {
    const Moments m = sums.ToMoments();
    const PrincipalAxes axes = ComputePrincipalAxes(m.scatter);
    mean = m.mean, normal = axes.vectors.col(0);
    axis1 = axes.vectors.col(1), axis2 = axes.vectors.col(2);
    count = m.count, residual = axes.values[0];
    lambda1 = std::max(axes.values[1], 1e-300), lambda2 = std::max(axes.values[2], 1e-300);
  }
  // Variance of the plane's height at a point, for unit noise.
  double HeightVariance(const Eigen::Vector3d& point) const {
    const double a = axis1.dot(point - mean), b = axis2.dot(point - mean);
    return 1.0 / count + a * a / lambda1 + b * b / lambda2;
  }
};

// Whether a cell's own plane continues the region's plane: the normal within three standard
// deviations (and a degree for the surface's own roughness), the height likewise.
bool Continues(const FittedPlane& plane, const PlanarCell& cell) {
  const double tilt = std::min(kDegree + 3.0 * cell.tilt, 15.0 * kDegree);
  if (std::abs(plane.normal.dot(cell.normal)) < std::cos(tilt)) return false;
  const double height = std::abs(plane.normal.dot(cell.mean - plane.mean));
  const double variance = 1.0 / cell.count + plane.HeightVariance(cell.mean);
  return height <= cell.sigma * std::min(0.5 + 3.0 * std::sqrt(variance), 3.0);
}

class Grower {
 public:
  Grower(const CellOctree& octree, const CellSplit& split,
         const std::vector<std::vector<std::uint32_t>>& neighbours, double planarity)
      : octree_(octree), split_(split), neighbours_(neighbours), planarity_(planarity) {}

  std::vector<Region> Run();

 private:
  CellSums Sums(std::uint32_t cell) const {
    return octree_.Sums(split_.planar[cell].level, split_.planar[cell].index);
  }
  std::vector<std::uint32_t> SeedsByQuality() const;
  void Grow(std::uint32_t seed);
  void MergeTouching();
  bool MayMerge(const Region& a, const Region& b) const;

  const CellOctree& octree_;
  const CellSplit& split_;
  const std::vector<std::vector<std::uint32_t>>& neighbours_;
  const double planarity_;
  std::vector<std::uint32_t> region_of_;
  std::vector<Region> regions_;
};

std::vector<std::uint32_t> Grower::SeedsByQuality() const {
  std::vector<std::uint32_t> seeds(split_.planar.size());
  std::iota(seeds.begin(), seeds.end(), 0u);
  std::stable_sort(seeds.begin(), seeds.end(), [&](std::uint32_t a, std::uint32_t b) {
    return split_.planar[a].tilt < split_.planar[b].tilt;
  });
  return seeds;
}

void Grower::Grow(std::uint32_t seed) {
  const auto id = static_cast<std::uint32_t>(regions_.size());
  Region region;
  region.Add(seed, Sums(seed), split_.planar[seed].sigma);
  region_of_[seed] = id;
  FittedPlane plane(region.sums);
  for (std::size_t head = 0; head < region.cells.size(); ++head) {
    for (const std::uint32_t next : neighbours_[region.cells[head]]) {
      if (region_of_[next] != kNone || !Continues(plane, split_.planar[next])) continue;
      region.Add(next, Sums(next), split_.planar[next].sigma);
      region_of_[next] = id;
      if (region.sums.count > kRefit * plane.count) plane = FittedPlane(region.sums);
    }
  }
  regions_.push_back(std::move(region));
}

bool Grower::MayMerge(const Region& a, const Region& b) const {
  const FittedPlane pa(a.sums), pb(b.sums);
  const double sigma = std::sqrt(std::max(a.ExpectedVariance(), b.ExpectedVariance()));
  const double tilt = sigma * (1.0 / std::sqrt(pa.lambda1) + 1.0 / std::sqrt(pb.lambda1));
  if (std::abs(pa.normal.dot(pb.normal)) < std::cos(std::min(kDegree + 3.0 * tilt, 0.2))) {
    return false;
  }
  CellSums sums = a.sums;
  sums.Add(b.sums);
  const double variance = (a.variance_sum + b.variance_sum) / sums.count;
  return IsPlanar(FittedPlane(sums).residual, sums.count, std::sqrt(variance), planarity_);
}

void Grower::MergeTouching() {
  std::map<std::pair<std::uint32_t, std::uint32_t>, int> touching;
  for (std::uint32_t c = 0; c < neighbours_.size(); ++c) {
    for (const std::uint32_t n : neighbours_[c]) {
      if (region_of_[c] < region_of_[n]) touching[{region_of_[c], region_of_[n]}]++;
    }
  }
  std::vector<std::uint32_t> target(regions_.size());
  std::iota(target.begin(), target.end(), 0u);
  const auto find = [&](std::uint32_t r) {
    while (target[r] != r) r = target[r];
    return r;
  };
  for (const auto& [pair, contacts] : touching) {
    const std::uint32_t a = find(pair.first), b = find(pair.second);
    if (a == b || !MayMerge(regions_[a], regions_[b])) continue;
    regions_[std::min(a, b)].Add(regions_[std::max(a, b)]);
    regions_[std::max(a, b)] = Region();
    target[std::max(a, b)] = std::min(a, b);
  }
  std::erase_if(regions_, [](const Region& region) { return region.cells.empty(); });
}

std::vector<Region> Grower::Run() {
  region_of_.assign(split_.planar.size(), kNone);
  for (const std::uint32_t seed : SeedsByQuality()) {
    if (region_of_[seed] == kNone) Grow(seed);
  }
  MergeTouching();
  std::stable_sort(regions_.begin(), regions_.end(),
                   [](const Region& a, const Region& b) { return a.sums.count > b.sums.count; });
  return std::move(regions_);
}

// The planar cell at or above that of the Morton code at `level`, or a negative mark.
std::int32_t OwnerAt(const CellOctree& octree, const CellSplit& split, int level,
                     std::uint64_t key) {
  for (int l = level; l < octree.levels(); ++l, key >>= 3) {
    const int cell = octree.Find(l, key);
    if (cell >= 0) return split.owner[l][cell];
    // An empty cell may still lie in a coarser planar one; only that is worth going on for.
  }
  return CellSplit::kSplit;
}

}  // namespace

void Region::Add(std::uint32_t cell, const CellSums& cell_sums, double sigma) {
  cells.push_back(cell);
  sums.Add(cell_sums);
  variance_sum += cell_sums.count * sigma * sigma;
}

void Region::Add(const Region& other) {
  cells.insert(cells.end(), other.cells.begin(), other.cells.end());
  sums.Add(other.sums);
  variance_sum += other.variance_sum;
}

std::vector<std::vector<std::uint32_t>> FindNeighbours(const CellOctree& octree,
                                                       const CellSplit& split) {
  std::vector<std::vector<std::uint32_t>> neighbours(split.planar.size());
  for (std::uint32_t i = 0; i < split.planar.size(); ++i) {
    const PlanarCell& cell = split.planar[i];
    const NeighbourKeys keys(octree.Level(cell.level)[cell.index].key);
    for (int k = 0; k < 27; ++k) {
      if (k == 13) continue;
      const std::int32_t other = OwnerAt(octree, split, cell.level, keys.At(k));
      if (other < 0 || static_cast<std::uint32_t>(other) == i) continue;
      neighbours[i].push_back(static_cast<std::uint32_t>(other));
      neighbours[other].push_back(i);
    }
  }
  for (auto& list : neighbours) {
    std::sort(list.begin(), list.end());
    list.erase(std::unique(list.begin(), list.end()), list.end());
  }
  return neighbours;
}

std::vector<Region> GrowRegions(const CellOctree& octree, const CellSplit& split,
                                const std::vector<std::vector<std::uint32_t>>& neighbours,
                                double planarity) {
  return Grower(octree, split, neighbours, planarity).Run();
}

}  // namespace planegraph
