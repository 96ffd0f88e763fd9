#pragma once

#include <string>
#include <vector>

namespace planegraph::tools {

/// The files of a glob in name order, or the clouds in a folder: `scan*.3d` where the format is
/// "3dtk", else every file with the ending of a cloud. Throws InputError where there is none.
std::vector<std::string> ScanFiles(const std::string& glob_or_folder, const std::string& format);

}  // namespace planegraph::tools
