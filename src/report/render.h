#pragma once

#include <string>

#include "planegraph/io/cloud_writer.h"
#include "report/json_access.h"
#include "report/viewer_input.h"

namespace planegraph {

/// The whole page. Both parts of `map`, and every part of `viewer`, may be empty.
std::string RenderReport(const Json& report, const MergedMap& map, const ViewerInput& viewer = {});

}  // namespace planegraph
