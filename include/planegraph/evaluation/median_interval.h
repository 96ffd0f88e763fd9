#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include "planegraph/evaluation/interval.h"

namespace planegraph {

/// The least count of values for which an interval of the median is given: between the least and
/// the greatest of n independent values the median lies with probability 1 - 2^(1-n), so with fewer
/// no two of them hold it with probability `level`.
std::size_t LeastForMedianInterval(double level);

/// The percentile interval of the bootstrap (Efron 1979, "Bootstrap methods: another look at the
/// jackknife") of the median, over all resamples at once: their medians' distribution is known in
/// closed form, so that no random numbers are drawn and the order of the values does not matter.
/// The median of an even count is the mean of the middle two. Nothing for fewer than
/// LeastForMedianInterval(level) values. O(n^2 log n) at worst.
std::optional<Interval> BootstrapMedianInterval(std::vector<double> values, double level);

}  // namespace planegraph
