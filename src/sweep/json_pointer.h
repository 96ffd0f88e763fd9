#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

namespace planegraph {

/// What a JSON pointer (RFC 6901) leads to, where the step `*` goes to every member of an object or
/// array; nothing where it leads nowhere. The pointer must be valid (PointerError in metrics.h).
std::vector<nlohmann::json> FollowPointer(const nlohmann::json& root, const std::string& pointer);

}  // namespace planegraph
