#pragma once

#include <Eigen/Core>
#include <utility>
#include <vector>

#include "planegraph/segmentation/plane_segment.h"

namespace planegraph {

/// The mask of points (projected to u, v about `origin`), closed by one dilation and erosion.
SupportMask BuildSupportMask(const Eigen::Vector3d& origin, const Eigen::Vector3d& u,
                             const Eigen::Vector3d& v, double cell_size,
                             const std::vector<Eigen::Vector2d>& projected);

/// Number of occupied cells times the area of one.
double MaskArea(const SupportMask& mask);

/// Convex hull of points in the plane, counter-clockwise (Andrew's monotone chain).
std::vector<Eigen::Vector2d> ConvexHull(std::vector<Eigen::Vector2d> points);

}  // namespace planegraph
