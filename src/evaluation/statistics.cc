#include "planegraph/evaluation/statistics.h"

#include <algorithm>
#include <cmath>

#include "planegraph/base/error.h"

namespace planegraph {
namespace {

double MedianInPlace(std::vector<double>* values) {
  const std::size_t half = values->size() / 2;
  std::nth_element(values->begin(), values->begin() + half, values->end());
  const double upper = (*values)[half];
  if (values->size() % 2 == 1) return upper;
  return 0.5 * (upper + *std::max_element(values->begin(), values->begin() + half));
}

}  // namespace

Statistics Summarize(std::vector<double> values) {
  if (values.empty()) throw NoResultError("there is no value to summarize");
  const double count = static_cast<double>(values.size());
  Statistics result;
  double squares = 0.0, deviations = 0.0;
  for (double v : values) {
    result.mean += v / count;
    squares += v * v;
  }
  for (double v : values) deviations += (v - result.mean) * (v - result.mean);
  result.rmse = std::sqrt(squares / count);
  result.std = std::sqrt(deviations / count);
  const auto [low, high] = std::minmax_element(values.begin(), values.end());
  result.min = *low;
  result.max = *high;
  result.median = MedianInPlace(&values);
  return result;
}

}  // namespace planegraph
