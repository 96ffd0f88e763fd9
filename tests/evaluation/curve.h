#pragma once

#include <cmath>

#include "planegraph/geometry/rotation.h"
#include "planegraph/io/trajectory_io.h"

namespace planegraph {

/// A curved path with a pose every 0.1 s, whose rotation vectors are `turning` times as long.
inline Trajectory Curve(std::size_t count, double turning = 1.0) {
  Trajectory trajectory;
  for (std::size_t i = 0; i < count; ++i) {
    const double t = 0.1 * static_cast<double>(i);
    trajectory.times.push_back(100.0 + t);
    trajectory.poses.emplace_back(ExpSO3(turning * Eigen::Vector3d(0.1 * t, 0.2 * std::sin(t), t)),
                                  Eigen::Vector3d(3.0 * std::cos(t), 2.0 * std::sin(t), 0.3 * t));
  }
  return trajectory;
}

}  // namespace planegraph
