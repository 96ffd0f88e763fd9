#pragma once

#include <Eigen/Core>
#include <vector>

namespace planegraph {

/// Area of the greedy projection triangulation (Marton et al. 2009, by PCL) of points that lie in a
/// plane, m^2. Points are thinned first, so that the longest edge, ten spacings, has a meaning.
/// Throws UsageError where the library was built without PCL.
double GreedyProjectionArea(const std::vector<Eigen::Vector2d>& points);

}  // namespace planegraph
