#include "tools/commands.h"

namespace planegraph::tools {

// One line declares and one lists a command; each is defined in tools/NAME.cc.

std::vector<Command> AllCommands() {
  return {
  };
}

}  // namespace planegraph::tools
