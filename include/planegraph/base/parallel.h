#pragma once

#include <cstddef>
#include <functional>

namespace planegraph {

/// Number of threads to use for a request, where 0 or less means all cores.
int ResolveThreads(int requested);

/// Calls body(i) for i in [0, count) on up to `threads` threads (0: all cores). Each index is
/// independent; results indexed by i are the same for every number of threads. The exception of the
/// smallest failing index is rethrown.
void ParallelFor(std::size_t count, int threads, const std::function<void(std::size_t)>& body);

}  // namespace planegraph
