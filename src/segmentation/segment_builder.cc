#include "segmentation/segment_builder.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>

#include "segmentation/greedy_projection_area.h"
#include "segmentation/support_mask.h"

namespace planegraph {
namespace {

// The outline of many points: only the extremes of each row of the mask can be corners.
std::vector<Eigen::Vector2d> RowExtremes(const std::vector<Eigen::Vector2d>& points,
                                         const SupportMask& mask) {
  std::vector<std::pair<int, int>> ends(mask.height, {-1, -1});
  for (std::size_t i = 0; i < points.size(); ++i) {
    const int row = static_cast<int>(std::floor(points[i].y() / mask.cell_size)) - mask.min_j;
    auto& [left, right] = ends[row];
    if (left < 0 || points[i].x() < points[left].x()) left = static_cast<int>(i);
    if (right < 0 || points[i].x() > points[right].x()) right = static_cast<int>(i);
  }
  std::vector<Eigen::Vector2d> extremes;
  for (const auto& [left, right] : ends) {
    if (left >= 0) extremes.push_back(points[left]);
    if (right >= 0 && right != left) extremes.push_back(points[right]);
  }
  return extremes;
}

}  // namespace

Plane LeastSquaresPlane(const Moments& moments, const Eigen::Vector3d& viewpoint) {
  Eigen::Vector3d normal = ComputePrincipalAxes(moments.scatter).vectors.col(0);
  if (normal.dot(viewpoint - moments.mean) < 0) normal = -normal;
  return {normal, normal.dot(moments.mean)};
}

Eigen::Matrix3d PlaneCovariance(const PlaneSegment& segment, double sigma,
                                const SegmentationOptions& options) {
  const double count = segment.moments.count;
  const double independent =
      std::clamp(segment.area / (options.correlation_length * options.correlation_length), 3.0,
                 std::max(count, 3.0));
  const double variance = sigma * sigma * count / independent;
  const double tilt_floor = options.floor_tilt_deg * std::numbers::pi / 180.0;
  Eigen::Vector3d diagonal;
  diagonal << variance / std::max(segment.axes.values[1], 1e-12) + tilt_floor * tilt_floor,
      variance / std::max(segment.axes.values[2], 1e-12) + tilt_floor * tilt_floor,
      variance / count + options.floor_offset * options.floor_offset;
  return diagonal.asDiagonal();
}

PlaneSegment BuildSegment(const Region& region, const Plane& plane,
                          const std::vector<Eigen::Vector3f>& points,
                          const std::vector<std::uint32_t>& members,
                          const SegmentationOptions& options) {
  PlaneSegment segment;
  segment.plane = plane;
  segment.source = options.kind;
  segment.moments = region.sums.ToMoments();
  segment.axes = ComputePrincipalAxes(segment.moments.scatter);
  segment.rms = std::sqrt(segment.axes.values[0] / segment.moments.count);
  segment.thickness = std::sqrt(region.ExpectedVariance());
  const Eigen::Vector3d u = segment.axes.vectors.col(1);
  const Eigen::Vector3d v = plane.normal.cross(u);
  std::vector<Eigen::Vector2d> projected;
  projected.reserve(members.size());
  const Eigen::Vector3d origin = segment.centroid();
  for (const std::uint32_t i : members) {
    const Eigen::Vector3d d = points[i].cast<double>() - origin;
    projected.emplace_back(d.dot(u), d.dot(v));
  }
  segment.mask = BuildSupportMask(origin, u, v, options.mask_cell_size, projected);
  segment.area =
      options.greedy_projection_area ? GreedyProjectionArea(projected) : MaskArea(segment.mask);
  for (const auto& corner : ConvexHull(RowExtremes(projected, segment.mask))) {
    segment.hull.push_back(origin + corner.x() * u + corner.y() * v);
  }
  const double sigma = std::max(segment.thickness, segment.rms);
  segment.covariance = PlaneCovariance(segment, sigma, options);
  return segment;
}

}  // namespace planegraph
