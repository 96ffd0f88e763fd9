#include "planegraph/correspondence/patch_map.h"

#include <algorithm>
#include <cmath>

#include "planegraph/geometry/cube_side.h"

namespace planegraph {
namespace {

// A query looks at three cells along the normal.
constexpr double kCell = SurfaceCells::kEdge;
constexpr double kReach = 0.75;  // a surfel answers within this share of its cell's edge
constexpr double kSlack = 0.1;   // metres beyond it

Eigen::Vector3i CellOf(const Eigen::Vector3d& point) {
  return {SurfaceCells::Of(point.x()), SurfaceCells::Of(point.y()), SurfaceCells::Of(point.z())};
}

double ReachOf(const Surfel& s) { return kReach * s.size + kSlack; }

// Each bit of the result depends on all of the key's.
inline std::uint64_t Mix(std::uint64_t key) {
  key *= 0x9e3779b97f4a7c15ull;
  key ^= key >> 32;
  key *= 0xd6e8feb86659fd93ull;
  return key ^ key >> 32;
}

// Of a cell; the lowest bits are left to the sides.
inline std::uint32_t Tag(std::uint64_t hash) {
  return static_cast<std::uint32_t>(hash >> 32) & ~SurfaceFilter::kAllSides;
}

// The cells that a surfel's square overlaps, as keys.
void CellsOf(const Surfel& s, std::vector<std::uint64_t>* keys) {
  keys->clear();
  const double reach = ReachOf(s);
  const Eigen::Vector3d extent =
      (Eigen::Vector3d::Ones() - s.normal.cwiseProduct(s.normal)).cwiseMax(0.0).cwiseSqrt() * reach;
  const Eigen::Vector3i low = CellOf(s.mean - extent), high = CellOf(s.mean + extent);
  for (int x = low.x(); x <= high.x(); ++x) {
    for (int y = low.y(); y <= high.y(); ++y) {
      for (int z = low.z(); z <= high.z(); ++z) {
        const Eigen::Vector3d centre(SurfaceCells::Centre(x), SurfaceCells::Centre(y),
                                     SurfaceCells::Centre(z));
        // The plane misses cells farther off than half a cell's diagonal.
        if (std::abs(s.normal.dot(centre - s.mean)) > 0.87 * kCell) continue;
        keys->push_back(SurfaceCells::Key(x, y, z));
      }
    }
  }
}

}  // namespace

double Surfel::HeightVariance(const Eigen::Vector3d& point) const {
  const Eigen::Vector3d d = point - mean;
  const double a = axis1.dot(d), b = axis2.dot(d);
  return offset_variance + a * a * variance1 + b * b * variance2;
}

namespace {

// Takes over the segment's normal, which more points have determined, where the patch's own does
// not contradict it.
void AdoptSegmentPlane(const PlaneSegment& segment, Surfel* surfel) {
  const double tilt = std::sqrt(std::max(surfel->variance1, surfel->variance2));
  const double cosine = segment.plane.normal.dot(surfel->normal);
  if (std::abs(cosine) < std::cos(std::min(3.0 * tilt, 0.3))) return;
  const bool same_side = cosine > 0.0;
  if (!same_side && segment.orientation == Orientation::kSensor) return;
  surfel->normal = same_side ? segment.plane.normal : Eigen::Vector3d(-segment.plane.normal);
  surfel->axis1 = segment.axes.vectors.col(1);
  surfel->axis2 = segment.axes.vectors.col(2);
  surfel->variance1 = segment.covariance(0, 0);
  surfel->variance2 = segment.covariance(1, 1);
}

Surfel Flipped(Surfel surfel) {
  surfel.normal = -surfel.normal;
  return surfel;
}

}  // namespace

double CorrelationLength(CloudKind kind) { return kind == CloudKind::kLaser ? 0.05 : 0.5; }

std::vector<Surfel> MakeSurfels(const PlaneSet& planes, double correlation_length) {
  std::vector<Surfel> surfels;
  surfels.reserve(planes.patches.size());
  for (const Patch& patch : planes.patches) {
    const PrincipalAxes axes = ComputePrincipalAxes(patch.moments.scatter);
    const double area = patch.size * patch.size;
    const double independent = std::clamp(area / (correlation_length * correlation_length), 1.0,
                                          std::max(1.0, patch.moments.count));
    const double variance = patch.sigma * patch.sigma * patch.moments.count / independent;
    surfels.push_back({patch.moments.mean, patch.normal, axes.vectors.col(1), axes.vectors.col(2),
                       variance / std::max(axes.values[1], 1e-12),
                       variance / std::max(axes.values[2], 1e-12), variance / patch.moments.count,
                       patch.size, area, patch.segment});
    if (patch.segment >= 0) AdoptSegmentPlane(planes.planes[patch.segment], &surfels.back());
    if (patch.orientation == Orientation::kUnknown) surfels.push_back(Flipped(surfels.back()));
  }
  return surfels;
}

PatchMap::PatchMap(std::vector<Surfel> surfels) : surfels_(std::move(surfels)) {
  std::vector<std::pair<std::uint64_t, std::uint32_t>> entries;
  std::vector<std::uint64_t> keys;
  faces_.reserve(surfels_.size());
  for (const Surfel& s : surfels_) faces_.push_back({s.normal, s.mean, ReachOf(s)});
  for (std::uint32_t i = 0; i < surfels_.size(); ++i) {
    CellsOf(surfels_[i], &keys);
    for (const std::uint64_t key : keys) entries.emplace_back(Mix(key), i);
  }
  std::uint64_t slots = 64;
  while (slots < entries.size()) slots *= 2;
  mask_ = slots - 1;
  starts_.assign(slots + 1, 0);
  filled_.assign(slots / 64, 0);
  for (const auto& [hash, i] : entries) ++starts_[(hash & mask_) + 1];
  for (std::uint64_t s = 0; s < slots; ++s) starts_[s + 1] += starts_[s];
  std::vector<std::uint32_t> next(starts_.begin(), starts_.end() - 1);
  items_.resize(entries.size());
  for (const auto& [hash, i] : entries) {
    const std::uint64_t slot = hash & mask_;
    items_[next[slot]++] = {Tag(hash) | SurfaceFilter::SidesNear(surfels_[i].normal), i};
    filled_[slot / 64] |= std::uint64_t{1} << slot % 64;
  }
  filter_ = SurfaceFilter(faces_);
}

struct PatchMap::Query {
  Eigen::Vector3d point, normal;
  double gate, least_cosine;
  std::uint32_t sides;     // one bit for each that counts
  double best = INFINITY;  // cost
  int found = -1;
};

inline void PatchMap::BestInCell(std::uint64_t hash, Query* query) const {
  const std::uint64_t slot = hash & mask_;
  for (std::uint32_t k = starts_[slot]; k < starts_[slot + 1]; ++k) {
    const std::uint32_t tag = items_[k].tag;
    if (Tag(std::uint64_t{tag} << 32) != Tag(hash) || (tag & query->sides) == 0) continue;
    const SurfaceFace& face = faces_[items_[k].surfel];
    const Eigen::Vector3d d = query->point - face.mean;
    const double height = std::abs(face.normal.dot(d));
    const double along = d.squaredNorm() - height * height;
    // One jump that is hard to foresee is cheaper than three.
    const bool turned = face.normal.dot(query->normal) < query->least_cosine;
    const bool off = height > query->gate, beside = along > face.reach * face.reach;
    if (turned | off | beside) continue;
    // Height first; among surfels of one surface the one that lies nearest in relation to its size.
    const double cost = height + 0.05 * std::sqrt(along) / face.reach;
    if (cost < query->best) query->best = cost, query->found = static_cast<int>(items_[k].surfel);
  }
}

int PatchMap::Find(const Eigen::Vector3d& point, const Eigen::Vector3d& normal, double gate,
                   double least_cosine) const {
  const bool alike = least_cosine >= SurfaceFilter::kCosine;
  const int side = CubeSide(normal);
  if (alike && gate <= SurfaceFilter::kGate && !filter_.MayLie(point, side)) return -1;
  Query query{point, normal, gate, least_cosine, alike ? 1u << side : SurfaceFilter::kAllSides};
  const auto look = [&](std::uint64_t key) {
    const std::uint64_t hash = Mix(key), slot = hash & mask_;
    if ((filled_[slot / 64] >> slot % 64 & 1) != 0) BestInCell(hash, &query);
  };
  const std::uint64_t centre = SurfaceCells::KeyOf(point);
  look(centre);
  // A surface at most `gate` off lies in this cell or in those that the gate reaches.
  const Eigen::Vector3d reach = std::min(gate, kCell) * normal;
  for (const double sign : {-1.0, 1.0}) {
    const std::uint64_t key = SurfaceCells::KeyOf(point + sign * reach);
    if (key != centre) look(key);
  }
  return query.found;
}

}  // namespace planegraph
