#pragma once

#include <Eigen/Core>
#include <vector>

#include "planegraph/geometry/sim3.h"

namespace planegraph {

/// Result of a closed-form alignment of point pairs.
struct Alignment {
  Sim3 target_from_source;
  /// Rank (0..3) of the centred positions: below 2 the rotation is not defined.
  int rank = 0;
};

/// Similarity (or rigid motion, with_scale = false) that minimizes the sum of squared distances of
/// target_from_source * source[i] to target[i] (Umeyama 1991). Needs at least one pair.
Alignment AlignPoints(const std::vector<Eigen::Vector3d>& source,
                      const std::vector<Eigen::Vector3d>& target, bool with_scale);

}  // namespace planegraph
