#pragma once

#include <cstddef>
#include <string>

namespace planegraph {

/// "1 scan", "2 scans".
inline std::string Counted(std::size_t count, const std::string& noun) {
  return std::to_string(count) + " " + noun + (count == 1 ? "" : "s");
}

}  // namespace planegraph
