#pragma once

#include <numbers>

namespace planegraph {

inline constexpr double kDegree = std::numbers::pi / 180.0;            ///< radians
inline constexpr double kDegreesPerRadian = 180.0 / std::numbers::pi;  ///< of an angle in radians

}  // namespace planegraph
