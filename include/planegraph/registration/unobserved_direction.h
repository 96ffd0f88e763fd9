#pragma once

#include <Eigen/Core>
#include <string>

namespace planegraph {

/// A direction of motion that the planes leave open: a pure translation (metres) or a pure rotation
/// (radians), in the axes of the target (of the world, for a pose of the graph).
struct UnobservedDirection {
  Eigen::Matrix<double, 6, 1> direction =
      Eigen::Matrix<double, 6, 1>::Zero();  ///< unit; x y z rx ry rz
  double sigma =
      0.0;  ///< standard deviation with everything that is known; infinity: nothing holds it
  std::string held_by;  ///< what holds it most: odometry, icp, prior; empty: nothing
};

}  // namespace planegraph
