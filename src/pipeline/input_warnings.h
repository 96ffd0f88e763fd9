#pragma once

#include <string>
#include <vector>

#include "planegraph/pipeline/site.h"

namespace planegraph {

/// Signs that a robot's input does not mean what it is taken for: times of the odometry that do not
/// increase. None of them changes the result.
std::vector<std::string> OdometryWarnings(const Site& site);

}  // namespace planegraph
