#pragma once

#include "planegraph/correspondence/map_hypotheses.h"

namespace planegraph {

/// How much more probable a pose is by the start than poses that the search comes upon by chance:
/// log of the normal density about the start over the even density of the window that is searched,
/// both of them over the window. Counted are the directions in which a search can be led astray: x,
/// y and the heading where the vertical is known (there the ground settles the others for right and
/// wrong poses alike), else all six. One start in ten is taken to be wrong, which bounds the answer
/// from below. 0 without a start. `extent`: metres, of the map along its axes.
double LogStartRatio(const Eigen::Vector3d& extent, const MapPrior& prior,
                     const Sim3& map_from_group);

}  // namespace planegraph
