#include "tools/commands.h"

namespace planegraph::tools {

// One line declares and one lists a command; each is defined in tools/NAME.cc.
Command ConvertCommand();
Command EvaluateCommand();
Command FactorsCommand();
Command GeoreferenceCommand();
Command LocateCommand();
Command MapCommand();
Command OptimizeCommand();
Command RegisterCommand();
Command ReportCommand();
Command SegmentCommand();
Command SimulateCommand();
Command SweepCommand();

std::vector<Command> AllCommands() {
  return {
      MapCommand(),          ReportCommand(),   SegmentCommand(),  RegisterCommand(),
      EvaluateCommand(),     SimulateCommand(), FactorsCommand(),  ConvertCommand(),
      GeoreferenceCommand(), LocateCommand(),   OptimizeCommand(), SweepCommand(),
  };
}

}  // namespace planegraph::tools
