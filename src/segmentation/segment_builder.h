#pragma once

#include <vector>

#include "planegraph/segmentation/segmenter.h"
#include "segmentation/region_growing.h"

namespace planegraph {

/// The least-squares plane of points with these moments, turned towards `viewpoint` (same frame).
Plane LeastSquaresPlane(const Moments& moments, const Eigen::Vector3d& viewpoint);

/// Covariance of a segment's tilt about its in-plane axes and of its offset at the centroid
/// (PlaneSegment::covariance): the noise of its points, of which only N_eff = min(N, A / l^2) count
/// as independent, plus the systematic floors.
Eigen::Matrix3d PlaneCovariance(const PlaneSegment& segment, double sigma,
                                const SegmentationOptions& options);

/// A segment from the region's moments (the boundary points, which may be mixed pixels, count for
/// the mask and the outline only). `members` index `points`.
PlaneSegment BuildSegment(const Region& region, const Plane& plane,
                          const std::vector<Eigen::Vector3f>& points,
                          const std::vector<std::uint32_t>& members,
                          const SegmentationOptions& options);

}  // namespace planegraph
