#include "planegraph/solve/association.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <memory>
#include <numeric>

namespace planegraph {
namespace {

// A patch of one scan or map in the world: one line of the cache.
struct WorldPatch {
  Eigen::Vector3d mean, normal;
  std::int32_t node, index;
  std::uint32_t rank;  ///< seeds go from the largest spread of points to the smallest
};

// A scan, or a map behind them.
struct Node {
  const PlaneSet* planes;
  Sim3 world_from_node;
  bool is_map;
  std::function<const Sim3&(const Eigen::Vector3d& place)> world_from_place;  // of a bent map
};

std::vector<Node> Nodes(const std::vector<const PlaneSet*>& scans, const std::vector<Rigid3>& poses,
                        const std::vector<PlacedMap>& maps) {
  std::vector<Node> nodes;
  for (std::size_t s = 0; s < scans.size(); ++s) {
    nodes.push_back({scans[s], Sim3(poses[s]), false, {}});
  }
  for (const PlacedMap& map : maps) {
    nodes.push_back({map.planes, map.world_from_map, true, map.world_from_place});
  }
  return nodes;
}

// Buckets of patches by the cell that their mean lies in; brings the patches into their order.
class Buckets {
 public:
  Buckets(double cell, std::vector<WorldPatch>* patches) : cell_(cell) {
    std::uint64_t slots = 64;
    while (slots < patches->size()) slots *= 2;
    mask_ = slots - 1;
    starts_.assign(slots + 1, 0);
    for (const auto& p : *patches) ++starts_[Slot(CellOf(p.mean)) + 1];
    std::partial_sum(starts_.begin(), starts_.end(), starts_.begin());
    std::vector<std::uint32_t> next(starts_.begin(), starts_.end() - 1);
    std::vector<WorldPatch> sorted(patches->size());
    for (const auto& p : *patches) sorted[next[Slot(CellOf(p.mean))]++] = p;
    patches->swap(sorted);
  }

  // Calls visit(i) for the patches in the 27 cells about a point; some lie farther off, and one may
  // be visited twice where two cells share a slot.
  template <typename Visit>
  void Around(const Eigen::Vector3d& point, Visit visit) const {
    const Eigen::Vector3i at = CellOf(point);
    for (int k = 0; k < 27; ++k) {
      const std::uint64_t slot = Slot(at + Eigen::Vector3i(k % 3 - 1, k / 3 % 3 - 1, k / 9 - 1));
      for (std::uint32_t i = starts_[slot]; i < starts_[slot + 1]; ++i) visit(i);
    }
  }

 private:
  Eigen::Vector3i CellOf(const Eigen::Vector3d& p) const {
    return (p / cell_).array().floor().cast<int>();
  }
  std::uint64_t Slot(const Eigen::Vector3i& c) const {
    std::uint64_t h = static_cast<std::uint32_t>(c.x()) * 0x9e3779b97f4a7c15ull;
    h ^= static_cast<std::uint32_t>(c.y()) * 0xc2b2ae3d27d4eb4full;
    h ^= static_cast<std::uint32_t>(c.z()) * 0x165667b19e3779f9ull;
    return (h ^ (h >> 32)) & mask_;
  }

  double cell_;
  std::uint64_t mask_ = 0;
  std::vector<std::uint32_t> starts_;
};

class Associator {
 public:
  Associator(std::vector<Node> nodes, std::size_t scan_count, const AssociationOptions& options);
  std::vector<PlaneLandmark> Run();

 private:
  const Patch& PatchOf(const WorldPatch& w) const {
    return nodes_[w.node].planes->patches[w.index];
  }
  bool IsMap(std::uint32_t patch) const { return nodes_[patches_[patch].node].is_map; }
  void RankPatches();
  double IndependentPoints(const Patch& patch, bool is_map) const;
  std::vector<std::uint32_t> Collect(const Eigen::Vector3d& centre, const Plane& plane) const;
  Plane FitPlane(const std::vector<std::uint32_t>& members) const;
  bool SeveralScans(const std::vector<std::uint32_t>& members) const;
  PlaneObservation Observe(const std::vector<std::uint32_t>& members, std::size_t first,
                           std::size_t last) const;
  PlaneLandmark MakeLandmark(std::vector<std::uint32_t> members, const Plane& plane) const;

  const std::vector<Node> nodes_;
  const std::size_t scan_count_;
  const AssociationOptions& options_;
  std::vector<WorldPatch> patches_;
  std::vector<std::uint32_t> by_rank_;
  std::vector<std::uint8_t> taken_;
  mutable std::vector<std::uint32_t> stamp_;
  mutable std::uint32_t epoch_ = 0;
  std::unique_ptr<Buckets> buckets_;
};

Associator::Associator(std::vector<Node> nodes, std::size_t scan_count,
                       const AssociationOptions& options)
    : nodes_(std::move(nodes)), scan_count_(scan_count), options_(options) {
  for (std::size_t n = 0; n < nodes_.size(); ++n) {
    const Node& node = nodes_[n];
    for (std::size_t i = 0; i < node.planes->patches.size(); ++i) {
      const Patch& patch = node.planes->patches[i];
      const Sim3& world_from_node =
          node.world_from_place ? node.world_from_place(patch.moments.mean) : node.world_from_node;
      patches_.push_back({world_from_node * patch.moments.mean,
                          world_from_node.rotation * patch.normal, static_cast<std::int32_t>(n),
                          static_cast<std::int32_t>(i), 0});
    }
  }
  RankPatches();
  taken_.assign(patches_.size(), 0);
  stamp_.assign(patches_.size(), 0);
  buckets_ = std::make_unique<Buckets>(options.radius, &patches_);
  by_rank_.resize(patches_.size());
  for (std::uint32_t i = 0; i < patches_.size(); ++i) by_rank_[patches_[i].rank] = i;
}

void Associator::RankPatches() {
  std::vector<std::pair<double, std::uint32_t>> order;
  order.reserve(patches_.size());
  for (std::uint32_t i = 0; i < patches_.size(); ++i) {
    const Patch& patch = PatchOf(patches_[i]);
    order.push_back({patch.size * std::sqrt(patch.moments.count), i});
  }
  std::stable_sort(order.begin(), order.end(),
                   [](const auto& a, const auto& b) { return a.first > b.first; });
  for (std::uint32_t r = 0; r < order.size(); ++r) patches_[order[r].second].rank = r;
}

double Associator::IndependentPoints(const Patch& patch, bool is_map) const {
  const double cells =
      patch.size / (is_map ? options_.map_correlation_length : options_.correlation_length);
  return std::clamp(cells * cells, 1.0, std::max(1.0, patch.moments.count));
}

std::vector<std::uint32_t> Associator::Collect(const Eigen::Vector3d& centre,
                                               const Plane& plane) const {
  std::vector<std::uint32_t> members;
  ++epoch_;
  const double map_gate = std::max(options_.gate, options_.map_gate);
  const double map_cosine = std::min(options_.least_cosine, options_.map_least_cosine);
  const double square = options_.radius * options_.radius;
  buckets_->Around(centre, [&](std::uint32_t i) {
    const WorldPatch& p = patches_[i];
    if (taken_[i] || stamp_[i] == epoch_ || (p.mean - centre).squaredNorm() > square) return;
    const bool is_map = IsMap(i);
    double cosine = p.normal.dot(plane.normal);
    if (is_map && PatchOf(p).orientation == Orientation::kUnknown) cosine = std::abs(cosine);
    if (cosine < (is_map ? map_cosine : options_.least_cosine)) return;
    if (std::abs(plane.SignedDistance(p.mean)) > (is_map ? map_gate : options_.gate)) return;
    stamp_[i] = epoch_;
    members.push_back(i);
  });
  std::sort(members.begin(), members.end(),
            [&](std::uint32_t a, std::uint32_t b) { return patches_[a].rank < patches_[b].rank; });
  return members;
}

Plane Associator::FitPlane(const std::vector<std::uint32_t>& members) const {
  const bool only_maps =
      std::all_of(members.begin(), members.end(), [&](std::uint32_t i) { return IsMap(i); });
  Moments sum;
  Eigen::Vector3d facing = Eigen::Vector3d::Zero();
  for (const std::uint32_t i : members) {
    // A drone map is coarser than the laser: it does not say where the surface lies.
    if (IsMap(i) && !only_maps) continue;
    sum.Merge(Transform(nodes_[patches_[i].node].world_from_node, PatchOf(patches_[i]).moments));
    facing += patches_[i].normal;
  }
  Eigen::Vector3d normal = ComputePrincipalAxes(sum.scatter).vectors.col(0);
  if (normal.dot(facing) < 0) normal = -normal;
  return {normal, normal.dot(sum.mean)};
}

// Several nodes, at least one of which is a scan.
bool Associator::SeveralScans(const std::vector<std::uint32_t>& members) const {
  const bool several = std::any_of(members.begin(), members.end(), [&](std::uint32_t i) {
    return patches_[i].node != patches_[members.front()].node;
  });
  return several &&
         std::any_of(members.begin(), members.end(), [&](std::uint32_t i) { return !IsMap(i); });
}

PlaneObservation Associator::Observe(const std::vector<std::uint32_t>& members, std::size_t first,
                                     std::size_t last) const {
  Moments sum;
  double independent = 0.0, variance = 0.0;
  const std::int32_t node = patches_[members[first]].node;
  const bool is_map = nodes_[node].is_map;
  for (std::size_t k = first; k < last; ++k) {
    const Patch& patch = PatchOf(patches_[members[k]]);
    sum.Merge(patch.moments);
    independent += IndependentPoints(patch, is_map);
    variance += patch.moments.count * patch.sigma * patch.sigma;
  }
  variance /= sum.count;
  const PrincipalAxes axes = ComputePrincipalAxes(sum.scatter);
  PlaneObservation seen;
  if (is_map) {
    seen.map = node - static_cast<int>(scan_count_);
  } else {
    seen.pose = node;
  }
  seen.centroid = sum.mean;
  seen.axes = axes.vectors;
  seen.eigenvalues = axes.values;
  seen.point_count = sum.count;
  const double share = sum.count / independent;
  const auto weight = [&](double noise, double floor) {
    return 1.0 / std::sqrt(variance * noise + floor * floor);
  };
  const double floor_tilt = is_map ? options_.map_floor_tilt : options_.floor_tilt;
  seen.tilt_weight_1 = weight(share / std::max(axes.values[1], 1e-12), floor_tilt);
  seen.tilt_weight_2 = weight(share / std::max(axes.values[2], 1e-12), floor_tilt);
  seen.offset_weight =
      weight(1.0 / independent, is_map ? options_.map_floor_offset : options_.floor_offset);
  return seen;
}

// Principal axes come with any sign; those of a landmark shall face alike. Turned about the third.
void FaceAs(const Eigen::Vector3d& normal, const Eigen::Quaterniond& world_from_node,
            PlaneObservation* seen) {
  if ((world_from_node * seen->axes.col(0)).dot(normal) < 0.0) seen->axes.leftCols<2>() *= -1.0;
}

PlaneLandmark Associator::MakeLandmark(std::vector<std::uint32_t> members,
                                       const Plane& plane) const {
  std::stable_sort(members.begin(), members.end(), [&](std::uint32_t a, std::uint32_t b) {
    return patches_[a].node < patches_[b].node;
  });
  PlaneLandmark landmark;
  for (const std::uint32_t i : members) landmark.anchor += patches_[i].mean;
  landmark.anchor /= static_cast<double>(members.size());
  landmark.normal = plane.normal;
  landmark.offset = plane.distance - plane.normal.dot(landmark.anchor);
  for (std::size_t first = 0, last = 0; first < members.size(); first = last) {
    while (last < members.size() && patches_[members[last]].node == patches_[members[first]].node) {
      ++last;
    }
    landmark.observations.push_back(Observe(members, first, last));
    FaceAs(plane.normal, nodes_[patches_[members[first]].node].world_from_node.rotation,
           &landmark.observations.back());
  }
  return landmark;
}

std::vector<PlaneLandmark> Associator::Run() {
  std::vector<PlaneLandmark> landmarks;
  for (const std::uint32_t seed : by_rank_) {
    if (taken_[seed] || IsMap(seed)) continue;
    const WorldPatch& p = patches_[seed];
    auto members = Collect(p.mean, {p.normal, p.normal.dot(p.mean)});
    if (members.empty() || !SeveralScans(members)) continue;
    const Plane plane = FitPlane(members);
    members = Collect(p.mean, plane);
    if (members.empty() || !SeveralScans(members)) continue;
    for (const std::uint32_t i : members) taken_[i] = 1;
    landmarks.push_back(MakeLandmark(std::move(members), plane));
  }
  return landmarks;
}

}  // namespace

std::vector<PlaneLandmark> AssociatePatches(const std::vector<const PlaneSet*>& scans,
                                            const std::vector<Rigid3>& world_from_scan,
                                            const AssociationOptions& options,
                                            const std::vector<PlacedMap>& maps) {
  return Associator(Nodes(scans, world_from_scan, maps), scans.size(), options).Run();
}

}  // namespace planegraph
