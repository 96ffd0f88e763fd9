#pragma once

#include <optional>
#include <vector>

#include "planegraph/graph/consistency.h"

namespace planegraph {

/// A relative pose along trusted measurements, with its covariance.
struct Way {
  RelativePose pose;
  int steps = 0;
};

/// Ways along a spanning forest of trusted measurements, of the most certain ones.
class TrustedWays {
 public:
  /// Throws std::invalid_argument for indices out of range.
  TrustedWays(int poses, const std::vector<RelativePose>& trusted);

  /// From one pose to all others: way.pose.target is `root`. Absent where nothing trusted leads, or
  /// only more than `most_steps`.
  std::vector<std::optional<Way>> From(int root, int most_steps) const;
  std::vector<std::optional<Way>> From(int root) const;

 private:
  std::vector<std::vector<RelativePose>> neighbours_;  // of each pose, which is the target
};

}  // namespace planegraph
