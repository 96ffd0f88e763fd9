#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace planegraph {

/// The name that somebody may have meant by `given`: the first of the least edit distance
/// (Levenshtein 1966), at most a third of its length; else the only one that `given` begins. Empty
/// where there is none.
std::string NearestName(std::string_view given, const std::vector<std::string>& names);

}  // namespace planegraph
