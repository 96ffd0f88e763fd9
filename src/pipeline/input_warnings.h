#pragma once

#include <string>
#include <vector>

#include "planegraph/pipeline/front_end.h"

namespace planegraph {

/// Signs that a robot's input does not mean what it is taken for; none of them changes the result.
/// Times of the odometry that do not increase.
std::vector<std::string> OdometryWarnings(const Site& site);

/// Robots most of whose scans have their points so far away that the unit may not be the metre.
std::vector<std::string> UnitsWarnings(const Site& site, const std::vector<ScanRecord>& scans);

}  // namespace planegraph
