#pragma once

#include <string>
#include <vector>

namespace planegraph {

/// How a process ended and what it took.
struct ChildResult {
  int exit_code = 0;         ///< 128 + N where signal N ended it, 127 where it could not be started
  int signal = 0;            ///< 0: none
  double cpu_seconds = 0.0;  ///< user and system
  double wall_seconds = 0.0;
  double peak_memory_bytes = 0.0;
};

/// Runs a program (argv[0] is its path) without a shell and waits for its end; stdout and stderr go
/// to the file `log`, which is made anew. The process does not outlive ours, even where that is
/// killed. May be called from several threads. Throws InputError where the log cannot be written or
/// no process can be made.
ChildResult RunChild(const std::vector<std::string>& argv, const std::string& log);

}  // namespace planegraph
