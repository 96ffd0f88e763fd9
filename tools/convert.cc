#include "planegraph/io/convert.h"

#include <gflags/gflags.h>

#include <cmath>
#include <iostream>

#include "planegraph/base/error.h"
#include "tools/command.h"

DEFINE_string(stamps, "",
              "time stamps of poses whose file has none: a file whose k-th line begins with the "
              "seconds of the k-th pose (to TUM)");
DEFINE_double(scale, 1.0,
              "metres per unit of the input: 0.001 for millimetres, 0.01 for centimetres");
DEFINE_string(axes, "x,y,z",
              "our x, y and z in the input, world and body alike: z,-x,-y for a camera's frame "
              "(x right, y down, z forward)");
DEFINE_string(quaternions, "xyzw", "order of the quaternions of a TUM input: xyzw, wxyz");
DEFINE_bool(inverse, false, "the poses of the input are body from world");

namespace planegraph::tools {
namespace {

FileConventions ConventionsFromFlags() {
  if (!(FLAGS_scale > 0.0) || !std::isfinite(FLAGS_scale)) {
    throw UsageError("--scale must be greater than zero");
  }
  if (FLAGS_quaternions != "xyzw" && FLAGS_quaternions != "wxyz") {
    throw UsageError("--quaternions must be xyzw or wxyz, not '" + FLAGS_quaternions + "'");
  }
  return {FLAGS_scale, ParseAxes(FLAGS_axes), FLAGS_quaternions == "wxyz", FLAGS_inverse};
}

int RunConvert(const std::vector<std::string>& arguments) {
  ExpectArguments(arguments, 2, 2);
  const Conversion conversion =
      ConvertFile(arguments[0], arguments[1], {FLAGS_stamps, ConventionsFromFlags()});
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
          {"stamps", "scale", "axes", "quaternions", "inverse"},
          RunConvert};
}

}  // namespace planegraph::tools
