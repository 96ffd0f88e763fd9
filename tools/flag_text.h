#pragma once

#include <string>

namespace planegraph::tools {

/// A flag's value as a user would write it: a double in the shortest form that reads back the same.
std::string FlagText(const std::string& type, const std::string& value);

}  // namespace planegraph::tools
