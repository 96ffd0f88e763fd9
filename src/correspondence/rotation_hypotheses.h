#pragma once

#include <vector>

#include "planegraph/correspondence/scan_model.h"

namespace planegraph {

/// A rotation with the share of the direction clusters' weight that it brings together.
struct RotationHypothesis {
  Eigen::Matrix3d target_from_source;
  double score = 0.0;
};

/// Rotations that align two pairs of directions, scored by all directions, best first, distinct by
/// 8 degrees.
std::vector<RotationHypothesis> FindRotations(const std::vector<DirectionCluster>& target,
                                              const std::vector<DirectionCluster>& source,
                                              std::size_t most);

}  // namespace planegraph
