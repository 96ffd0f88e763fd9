#pragma once

#include <cstddef>
#include <optional>
#include <utility>
#include <vector>

namespace planegraph {

// Confidence intervals by the delete-a-block jackknife (Kuensch 1989, "The jackknife and the
// bootstrap for general stationary observations"): neighbouring errors along a path are alike, so
// blocks of consecutive ones are left out, not single ones. It draws no random numbers. An interval
// says how far the figure would move over other stretches of the same kind of way or surface; it
// knows nothing of errors that the whole run shares.

struct Interval {
  double low = 0.0, high = 0.0;
};

struct IntervalOptions {
  double level = 0.95;      ///< probability that the interval holds the figure, in (0, 1)
  std::size_t blocks = 20;  ///< at most; fewer than this many values: one block each
};
/// Least blocks of an interval.
inline constexpr std::size_t kLeastBlocks = 4;

/// The value that a t-distributed variable with `degrees` >= 1 stays below with `probability` in
/// (0, 1).
double StudentQuantile(double probability, std::size_t degrees);

/// [first, last) of up to `blocks` blocks of consecutive values, of sizes that differ by at most 1.
std::vector<std::pair<std::size_t, std::size_t>> ConsecutiveBlocks(std::size_t count,
                                                                   std::size_t blocks);

/// The interval of an estimate from the same estimates without one block each (Student's t with a
/// degree less than there are blocks). Nothing for fewer than kLeastBlocks of them.
std::optional<Interval> JackknifeInterval(double estimate, const std::vector<double>& without,
                                          double level);
/// The same for a magnitude (at least 0): taken of its logarithm, so that it stays above 0.
std::optional<Interval> JackknifeMagnitude(double estimate, const std::vector<double>& without,
                                           double level);

/// Sum and count of the values of one block.
struct BlockSum {
  double sum = 0.0, count = 0.0;
};
/// The interval of sum/count over all blocks, whose counts may differ; blocks are what is
/// independent. Nothing for fewer than kLeastBlocks that hold a value.
std::optional<Interval> MeanInterval(const std::vector<BlockSum>& blocks, double level);

}  // namespace planegraph
