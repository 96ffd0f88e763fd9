#pragma once

#include <Eigen/Core>
#include <vector>

#include "planegraph/segmentation/plane_segment.h"

namespace planegraph {

/// For clouds without normals: turns each patch to the side where most of the cameras stand, the
/// nearer ones above all. Where they stand on both sides, or nowhere, its orientation stays as it
/// is. `centres`: in the patches' frame; `threads` changes nothing but the time.
void OrientByCameras(const std::vector<Eigen::Vector3d>& centres, int threads, PlaneSet* planes);

}  // namespace planegraph
