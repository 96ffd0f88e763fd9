#pragma once

#include <filesystem>
#include <map>
#include <set>
#include <string>
#include <vector>

namespace planegraph::layering {

/// Each module with all modules below it, as the DEPENDS of src/CMakeLists.txt say.
using Layers = std::map<std::string, std::set<std::string>>;

/// Reads the layers from the text of src/CMakeLists.txt. Throws std::runtime_error where a module
/// depends on one that is not listed before it.
Layers ParseLayers(const std::string& cmake_lists);

/// The includes under `root` (a checkout) that break a rule, as "FILE:LINE: REASON", in file order.
std::vector<std::string> FindViolations(const std::filesystem::path& root);

}  // namespace planegraph::layering
