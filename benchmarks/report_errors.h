#pragma once

#include <cstdio>
#include <exception>

namespace planegraph {

/// What the main of a table's program returns: what `run` does, or 2 where it throws, saying why.
template <typename Body>
int ReportErrors(const Body& run) {
  try {
    return run();
  } catch (const std::exception& error) {
    std::fprintf(stderr, "error: %s\n", error.what());
    return 2;
  }
}

}  // namespace planegraph
