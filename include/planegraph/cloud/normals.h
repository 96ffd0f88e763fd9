#pragma once

#include <Eigen/Core>
#include <vector>

#include "planegraph/cloud/cloud.h"

namespace planegraph {

/// The shape of the surface about a point, from its k nearest neighbours (itself included).
struct LocalShape {
  Eigen::Vector3f normal = Eigen::Vector3f::Zero();  ///< unit, towards the viewpoint
  /// Variances of the neighbours along the principal axes, increasing, m^2.
  Eigen::Vector3f variances = Eigen::Vector3f::Zero();
};

/// One shape per point; with fewer than three points all are zero. `k` >= 3, `threads` 0: all
/// cores.
std::vector<LocalShape> ComputeLocalShapes(const Cloud& cloud, std::size_t k, int threads = 1);

/// The cloud with normals from the k nearest neighbours, turned towards its viewpoint.
Cloud WithNormals(Cloud cloud, std::size_t k, int threads = 1);

}  // namespace planegraph
