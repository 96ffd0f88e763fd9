#include "solve/metascan_map.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace planegraph {
namespace {

void Transform(const Rigid3& to_from, PlaneBox* box) {
  box->center = to_from * box->center;
  box->u = to_from.rotation * box->u;
  box->v = to_from.rotation * box->v;
}

// The box in its own axes grows to hold another one.
void Extend(const PlaneBox& other, PlaneBox* box) {
  const Eigen::Vector3d apart = other.center - box->center;
  Eigen::Vector3d shift = Eigen::Vector3d::Zero();
  const auto extend = [&](const Eigen::Vector3d& axis, double* half) {
    const double at = axis.dot(apart), reach = std::abs(axis.dot(other.u)) * other.half_u +
                                               std::abs(axis.dot(other.v)) * other.half_v;
    const double low = std::min(-*half, at - reach), high = std::max(*half, at + reach);
    *half = 0.5 * (high - low);
    shift += 0.5 * (high + low) * axis;
  };
  extend(box->u, &box->half_u);
  extend(box->v, &box->half_v);
  box->center += shift;
}

MetaSegment Start(const WorldSegment& first) {
  MetaSegment meta;
  meta.moments = Transform(first.world_from_scan, first.segment->moments);
  meta.normal = first.normal;
  meta.box = first.box;
  meta.members = {&first};
  return meta;
}

void Join(const WorldSegment& more, MetaSegment* meta) {
  meta->moments.Merge(Transform(more.world_from_scan, more.segment->moments));
  meta->normal =
      (meta->normal * meta->moments.count + more.normal * more.segment->moments.count).normalized();
  Extend(more.box, &meta->box);
  meta->members.push_back(&more);
}

// The plane of the merged points, at least as well known as the best member's.
void Fit(MetaSegment* meta) {
  const PrincipalAxes axes = ComputePrincipalAxes(meta->moments.scatter);
  Eigen::Vector3d normal = axes.vectors.col(0);
  if (normal.dot(meta->normal) < 0) normal = -normal;
  Eigen::Vector3d variances = Eigen::Vector3d::Constant(1e6);
  double own = 0.0;
  for (const WorldSegment* member : meta->members) {
    variances = variances.cwiseMin(member->segment->covariance.diagonal());
    own += member->segment->axes.values[0];
  }
  // Scatter that the members do not have by themselves: they are not quite one plane.
  const double excess = std::max(0.0, axes.values[0] - own);
  variances +=
      excess * Eigen::Vector3d(1.0 / std::max(axes.values[1], 1e-9),
                               1.0 / std::max(axes.values[2], 1e-9), 1.0 / meta->moments.count);
  meta->normal = normal;
  meta->plane = {normal, meta->moments.mean,
                 variances[0] * axes.vectors.col(1) * axes.vectors.col(1).transpose() +
                     variances[1] * axes.vectors.col(2) * axes.vectors.col(2).transpose(),
                 variances[2]};
}

}  // namespace

std::vector<WorldSegment> PlaceSegments(const PlaneSet& scan, const Rigid3& world_from_scan,
                                        double min_area) {
  std::vector<WorldSegment> placed;
  for (const PlaneSegment& s : scan.planes) {
    if (s.area < min_area) continue;
    WorldSegment w{&s, world_from_scan, world_from_scan.rotation * s.plane.normal,
                   world_from_scan * s.centroid(), MakePlaneBox(s)};
    Transform(world_from_scan, &w.box);
    placed.push_back(w);
  }
  return placed;
}

CoincidenceGate::CoincidenceGate(double max_angle_deg, double offset, double overlap_tolerance)
    : least_cosine(std::cos(max_angle_deg * std::numbers::pi / 180.0)),
      max_offset(offset),
      tolerance(overlap_tolerance) {}

bool CoincidenceGate::Admits(const Eigen::Vector3d& normal, const Eigen::Vector3d& centroid,
                             const PlaneBox& box, const WorldSegment& other) const {
  if (normal.dot(other.normal) < least_cosine) return false;
  const Eigen::Vector3d apart = other.centroid - centroid;
  // Half of the tilt's effect over the distance of the centroids, as in the closed form.
  if (std::abs((normal + other.normal).dot(apart)) > 2.0 * max_offset) return false;
  return BoxesOverlap(box, other.box, Eigen::Matrix3d::Identity(), Eigen::Vector3d::Zero(),
                      tolerance);
}

double MetaSegment::Area() {
  if (area_ >= 0.0) return area_;
  // A bitmap of the box in its own axes, of at most kMostCells each way.
  constexpr double kMostCells = 32;
  const double cell = std::max(members[0]->segment->mask.cell_size,
                               2 * std::max(box.half_u, box.half_v) / kMostCells);
  const int wide = static_cast<int>(std::ceil(2 * box.half_u / cell));
  const int high = static_cast<int>(std::ceil(2 * box.half_v / cell));
  std::vector<std::uint8_t> seen(std::size_t(wide) * high, 0);
  for (const WorldSegment* member : members) {
    const Rigid3 scan_from_world = member->world_from_scan.Inverse();
    const SupportMask& mask = member->segment->mask;
    const Eigen::Vector3d u = scan_from_world.rotation * box.u;
    const Eigen::Vector3d v = scan_from_world.rotation * box.v;
    const Eigen::Vector3d corner =
        scan_from_world * box.center - box.half_u * u - box.half_v * v - mask.origin;
    for (int y = 0; y < high; ++y) {
      for (int x = 0; x < wide; ++x) {
        const Eigen::Vector3d d = corner + (x + 0.5) * cell * u + (y + 0.5) * cell * v;
        seen[std::size_t(y) * wide + x] |=
            mask.Occupied(static_cast<int>(std::floor(d.dot(mask.u) / mask.cell_size)),
                          static_cast<int>(std::floor(d.dot(mask.v) / mask.cell_size)));
      }
    }
  }
  area_ = cell * cell * static_cast<double>(std::count(seen.begin(), seen.end(), 1));
  return area_;
}

std::vector<MetaSegment> MergeSegments(
    const std::vector<const std::vector<WorldSegment>*>& neighbours, const CoincidenceGate& gate) {
  std::vector<const WorldSegment*> order;
  for (const auto* scan : neighbours) {
    for (const WorldSegment& s : *scan) order.push_back(&s);
  }
  std::stable_sort(order.begin(), order.end(), [](const auto* a, const auto* b) {
    return a->segment->area > b->segment->area;
  });
  std::vector<MetaSegment> merged;
  for (const WorldSegment* s : order) {
    const auto home = std::find_if(merged.begin(), merged.end(), [&](const MetaSegment& meta) {
      return gate.Admits(meta.normal, meta.moments.mean, meta.box, *s);
    });
    if (home == merged.end()) {
      merged.push_back(Start(*s));
    } else {
      Join(*s, &*home);
    }
  }
  for (MetaSegment& meta : merged) Fit(&meta);
  return merged;
}

}  // namespace planegraph
