#include "planegraph/io/convert.h"

#include <gflags/gflags.h>

#include <iostream>

#include "tools/command.h"

DEFINE_string(stamps, "",
              "time stamps of poses whose file has none: a file whose k-th line begins with the "
              "seconds of the k-th pose (to TUM)");

namespace planegraph::tools {
namespace {

int RunConvert(const std::vector<std::string>& arguments) {
  ExpectArguments(arguments, 2, 2);
  const Conversion conversion = ConvertFile(arguments[0], arguments[1], {FLAGS_stamps});
  if (WantsText()) {
    const char* noun = conversion.kind == "cloud"        ? "points"
                       : conversion.kind == "trajectory" ? "poses"
                                                         : "vertices";
    std::cout << arguments[1] << ": " << conversion.count << " " << noun << "\n";
  }
  EmitResult({{"kind", conversion.kind},
              {"count", conversion.count},
              {"input", arguments[0]},
              {"output", arguments[1]}},
             false);
  return 0;
}

}  // namespace

Command ConvertCommand() {
  return {"convert",
          "IN OUT",
          "clouds and trajectories from one format to another",
          {"stamps"},
          RunConvert};
}

}  // namespace planegraph::tools
