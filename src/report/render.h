#pragma once

#include <string>

#include "planegraph/cloud/cloud.h"
#include "report/json_access.h"

namespace planegraph {

/// The whole page. `map` may be empty.
std::string RenderReport(const Json& report, const Cloud& map);

}  // namespace planegraph
