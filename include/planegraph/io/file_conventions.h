#pragma once

#include <Eigen/Core>
#include <string>

#include "planegraph/cloud/cloud.h"
#include "planegraph/io/trajectory_io.h"

namespace planegraph {

/// What the numbers of a file mean where they do not mean what its format says.
struct FileConventions {
  double scale = 1.0;  ///< metres per unit of the file
  /// A signed permutation: our axes from the file's, of the world and of the body alike. Its
  /// determinant is -1 where the file's axes are left-handed.
  Eigen::Matrix3d axes = Eigen::Matrix3d::Identity();
  bool w_first = false;          ///< quaternions are qw qx qy qz; trajectories alone
  bool body_from_world = false;  ///< trajectories alone
};

/// The axes of a text "X,Y,Z": what our x, y and z are in the file, each x, y or z with or without
/// a minus. A camera's frame (x right, y down, z forward) is "z,-x,-y". Throws UsageError.
Eigen::Matrix3d ParseAxes(const std::string& text);
/// The inverse of ParseAxes.
std::string AxesText(const Eigen::Matrix3d& axes);

/// The trajectory in metres, right-handed, world_from_body, which was read as if its file had no
/// conventions of its own.
Trajectory Interpret(const FileConventions& conventions, const Trajectory& as_read);
/// Likewise the cloud; normals and viewpoint with it.
Cloud Interpret(const FileConventions& conventions, Cloud as_read);

}  // namespace planegraph
