#pragma once

#include <string>
#include <utility>
#include <vector>

namespace planegraph::cli {

/// What one run of the tool left behind.
struct Outcome {
  int exit_code = -1;
  std::string out, err;
};

/// Runs `planegraph ARGUMENTS` (split by the shell) in a folder of its own and waits for its end.
Outcome RunTool(const std::string& arguments);

/// The commands that `planegraph help` lists.
std::vector<std::string> ListedCommands();

/// The flags that `planegraph COMMAND --help` lists as its own, each with its default value.
std::vector<std::pair<std::string, std::string>> ListedFlags(const std::string& command);

}  // namespace planegraph::cli
