#pragma once

#include <string>

#include "planegraph/io/cloud_writer.h"
#include "report/json_access.h"

namespace planegraph {

/// The whole page. Both parts of `map` may be empty.
std::string RenderReport(const Json& report, const MergedMap& map);

}  // namespace planegraph
