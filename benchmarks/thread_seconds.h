#pragma once

#include <time.h>

namespace planegraph {

/// CPU time of this thread, seconds: others may use the machine meanwhile.
inline double ThreadSeconds() {
  timespec now{};
  ::clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

}  // namespace planegraph
