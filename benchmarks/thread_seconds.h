#pragma once

#include <algorithm>
#include <cmath>
#include <ctime>

namespace planegraph {

/// CPU time of this thread, seconds: others may use the machine meanwhile.
inline double ThreadSeconds() {
  timespec now{};
  ::clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

/// Least time of `repeats` calls, or of as many as take `most_seconds` together: what else the
/// machine does only adds to it.
template <typename Body>
double LeastSeconds(int repeats, const Body& body, double most_seconds = INFINITY) {
  double least = INFINITY, sum = 0.0;
  for (int k = 0; k < repeats && sum < most_seconds; ++k) {
    const double start = ThreadSeconds();
    body();
    const double seconds = ThreadSeconds() - start;
    least = std::min(least, seconds), sum += seconds;
  }
  return least;
}

}  // namespace planegraph
