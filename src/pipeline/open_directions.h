#pragma once

#include "planegraph/graph/graph.h"
#include "planegraph/pipeline/joint_solve.h"

namespace planegraph {

/// Adds factors that hold, by odometry, what the planes of two consecutive scans and all other
/// registrations leave open between them.
void HoldOpenDirections(const JointProblem& problem, const JointSolution& solution, Graph* graph);

}  // namespace planegraph
