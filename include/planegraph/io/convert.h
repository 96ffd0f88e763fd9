#pragma once

#include <cstddef>
#include <string>

#include "planegraph/io/file_conventions.h"

namespace planegraph {

/// What ConvertFile did.
struct Conversion {
  std::string kind;       ///< "cloud", "trajectory" or "graph"
  std::size_t count = 0;  ///< points, poses, or vertices
};

struct ConvertOptions {
  /// A file of time stamps (ReadTimeStamps), the k-th for the k-th pose; "": none. For inputs
  /// without times of their own and TUM as output.
  std::string stamps;
  /// What the numbers of the input mean where they do not mean what its format says.
  FileConventions conventions = {};
};

/// Converts a cloud or a trajectory. The ending of `output` says the format and with it the kind:
/// .ply .pcd .xyz .3d clouds; .tum .kitti .g2o trajectories (g2o: vertices alone, unless the input
/// is g2o too), a folder (a name with '/' at its end, without an ending, or ending in .frames)
/// 3DTK's scanNNN.frames; .txt what the input is: XYZ or TUM. Inputs are told apart by ending and
/// content as in ReadCloud and ReadTrajectory. Throws InputError, also where a cloud is asked of a
/// trajectory or there are not as many stamps as poses; UsageError where stamps are given for an
/// output that holds none, or conventions for what the input does not hold.
Conversion ConvertFile(const std::string& input, const std::string& output,
                       const ConvertOptions& options = {});

}  // namespace planegraph
