#include "tools/commands.h"

namespace planegraph::tools {

// One line declares and one lists a command; each is defined in tools/NAME.cc.
Command EvaluateCommand();
Command SimulateCommand();
Command FactorsCommand();

std::vector<Command> AllCommands() {
  return {
      EvaluateCommand(),
      SimulateCommand(),
      FactorsCommand(),
  };
}

}  // namespace planegraph::tools
