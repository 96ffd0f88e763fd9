#pragma once

#include <functional>
#include <vector>

#include "planegraph/solve/covariance.h"
#include "planegraph/solve/observability.h"
#include "solve/information.h"

namespace planegraph {

/// The open motions of a graph by the information of its planes, in nodes. Sigmas with all that is
/// known are left to the caller. Relative to one node of each component (joined by planes), the one
/// that its planes hold best; parts do not depend on it.
std::vector<OpenMotion> FindOpenMotions(const Graph& graph, const PoseInformation& by_planes,
                                        const CovarianceOptions& options);

/// How a node k moves as seen from node i at where k is: 3 rows of translation and 3 of rotation in
/// world axes, by the perturbations of i and of k.
struct SeenMotion {
  Eigen::MatrixXd by_i, by_k;
};
SeenMotion MotionSeenFrom(const Graph& graph, int i, int k);

}  // namespace planegraph
