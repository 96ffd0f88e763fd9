#pragma once

#include <cstddef>
#include <vector>

namespace planegraph {

/// What is reported of a set of errors. `std` is that of the population (divided by the count).
struct Statistics {
  double rmse = 0.0, mean = 0.0, median = 0.0, std = 0.0, min = 0.0, max = 0.0;
};

/// Statistics of at least one value; the median of an even count is the mean of the middle two.
/// Throws NoResultError where there is no value.
Statistics Summarize(std::vector<double> values);

}  // namespace planegraph
