#include "tools/commands.h"

namespace planegraph::tools {

// One line declares and one lists a command; each is defined in tools/NAME.cc.
Command SimulateCommand();

std::vector<Command> AllCommands() {
  return {
      SimulateCommand(),
  };
}

}  // namespace planegraph::tools
