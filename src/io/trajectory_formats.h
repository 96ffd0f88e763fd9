#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "planegraph/io/trajectory_io.h"

// The readers of one format each, from a file's whole content. They throw InputError.

namespace planegraph {

/// TUM or KITTI, by the number of columns of the first line.
Trajectory ParseTrajectory(std::string_view bytes, const std::string& file);
/// See ReadTimeStamps.
std::vector<double> ParseTimeStamps(std::string_view bytes, const std::string& file);
Rigid3 Parse3dtkFrames(std::string_view bytes, const std::string& file);
Rigid3 Parse3dtkPose(std::string_view bytes, const std::string& file);
/// A rotation matrix of a text: the nearest rotation. Throws InputError where it is none within
/// 0.01.
Eigen::Quaterniond CheckedRotation(const Eigen::Matrix3d& matrix, const std::string& file,
                                   std::size_t line);

}  // namespace planegraph
