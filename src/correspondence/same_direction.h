#pragma once

#include <cmath>
#include <numbers>

namespace planegraph {

/// Cosine of the angle (6 degrees) within which the directions of planes are gathered to one.
inline const double kOneDirection = std::cos(6.0 * std::numbers::pi / 180.0);

}  // namespace planegraph
