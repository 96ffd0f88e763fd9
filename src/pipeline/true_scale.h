#pragma once

#include <string>

namespace planegraph {

/// The `scale` (metres per unit) of a JSON file. Throws InputError where there is none above zero.
double ReadTrueScale(const std::string& path);

}  // namespace planegraph
