#pragma once

#include <string>

#include "report/viewer_input.h"

namespace planegraph {

/// The 3-D view's place on the page: an empty box that the script fills, and what stands there
/// without a script. Empty where there is nothing to show.
std::string ViewerHtml(const ReportData& data, const ViewerInput& input);

/// Points, scene and script, for the end of the page: tables and pictures are there before them.
std::string ViewerScriptsHtml(const ReportData& data, const ViewerInput& input);

}  // namespace planegraph
