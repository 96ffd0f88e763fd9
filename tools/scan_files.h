#pragma once

#include <string>
#include <vector>

namespace planegraph::tools {

/// Scans in the order of their files, and the format to read them in.
struct ScanList {
  std::vector<std::string> files;
  std::string format;
};

/// The files of a glob in name order, or the clouds in a folder: `scan*.3d` where the format is
/// "3dtk", else every file with the ending of a cloud. Of a site file (.yaml, .yml) the scans of
/// its robot, in the format that it names where `format` is "auto". Throws InputError where there
/// is none, UsageError of a site with several robots.
ScanList FindScans(const std::string& glob_folder_or_site, const std::string& format);

}  // namespace planegraph::tools
