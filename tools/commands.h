#pragma once

#include "tools/command.h"

namespace planegraph::tools {

/// All subcommands in the order of `planegraph help`.
std::vector<Command> AllCommands();

}  // namespace planegraph::tools
