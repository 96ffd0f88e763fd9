#pragma once

#include <algorithm>
#include <cstddef>
#include <vector>

namespace planegraph {

/// The middle value (the upper one of two), or `fallback` where there is none. O(N).
inline double Median(std::vector<double> values, double fallback = 0.0) {
  if (values.empty()) return fallback;
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

}  // namespace planegraph
