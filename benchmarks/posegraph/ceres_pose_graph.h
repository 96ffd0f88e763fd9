#pragma once

#include "planegraph/pose_graph/pose_graph.h"

namespace planegraph {

/// What one writes first with Ceres: automatic derivatives, a translation and a quaternion block a
/// pose, Ceres' defaults but the solver for sparse normal equations. The yardstick of the table.
struct CeresResult {
  double cost = 0.0, seconds = 0.0;
  int iterations = 0;
};
CeresResult SolveWithCeres(const PoseGraph3& graph);

}  // namespace planegraph
