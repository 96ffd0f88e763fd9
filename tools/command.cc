#include "tools/command.h"

#include <gflags/gflags.h>

#include <chrono>
#include <iostream>

#include "planegraph/base/atomic_file.h"
#include "planegraph/base/error.h"
#include "planegraph_version.h"
#include "tools/commands.h"
#include "tools/common_flags.h"
#include "tools/flag_text.h"

DEFINE_int32(threads, 0, "number of threads (0: all cores)");
DEFINE_uint64(seed, 0, "seed of everything random");
DEFINE_bool(json, false, "print the result as one JSON object on stdout");
DEFINE_bool(quiet, false, "print nothing but errors");
DEFINE_int32(log_level, 1, "least severity logged: 0 info, 1 warning, 2 error");
DEFINE_string(output, "", "file for the result");
DEFINE_string(output_dir, "", "folder for the results");
DEFINE_string(format, "auto", "of the clouds: auto, ply, pcd, xyz, 3dtk");
DEFINE_string(cameras, "",
              "cameras of a photogrammetric model: MVE, Bundler, COLMAP folder, OpenSfM");
DEFINE_string(gps, "", "positions: CSV by time or image, NMEA, or a folder of images with EXIF");
DEFINE_string(image_times, "", "CSV with time,file; row k belongs to camera k");
DEFINE_string(method, "",
              "georeference: robust or paper; locate: vote or cells (default: the first)");
DEFINE_double(min_range, 0.5,
              "points of a scan nearer to the scanner than this are dropped, metres");

namespace planegraph::tools {
namespace {

const auto kStart = std::chrono::steady_clock::now();

nlohmann::json ChangedFlags() {
  nlohmann::json flags = nlohmann::json::object();
  std::vector<gflags::CommandLineFlagInfo> all;
  gflags::GetAllFlags(&all);
  for (const auto& flag : all) {
    // Only flags of our own: glog's are set by the tool itself.
    const bool ours = flag.filename.find("tools/") != std::string::npos;
    if (ours && !flag.is_default) flags[flag.name] = FlagText(flag.type, flag.current_value);
  }
  return flags;
}

// Of the command that runs: main.cc hands gflags its name as the program's.
std::string UsageLine() {
  for (const Command& command : AllCommands()) {
    if (command.name != gflags::GetArgv0()) continue;
    return ": planegraph " + command.name + " [--flags] " + command.arguments;
  }
  return "";
}

}  // namespace

void ExpectArguments(const std::vector<std::string>& arguments, std::size_t least,
                     std::size_t most) {
  if (arguments.size() < least) throw UsageError("an argument is missing" + UsageLine());
  if (arguments.size() > most) throw UsageError("unexpected argument: " + arguments[most]);
}

void RequireFlag(const std::string& name) {
  std::string value;
  if (gflags::GetCommandLineOption(name.c_str(), &value) && value.empty()) {
    throw UsageError("the flag --" + name + " is missing");
  }
}

std::string FlagFile(std::vector<std::string> flags) {
  flags.insert(flags.end(), {"threads", "seed"});
  std::string text;
  for (const auto& name : flags) {
    gflags::CommandLineFlagInfo flag;
    if (gflags::GetCommandLineFlagInfo(name.c_str(), &flag)) {
      text += "--" + name + "=" + FlagText(flag.type, flag.current_value) + "\n";
    }
  }
  return text;
}

double SecondsSinceStart() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - kStart).count();
}

nlohmann::json VersionStamp() {
  return {{"version", PLANEGRAPH_VERSION},
          {"commit", PLANEGRAPH_COMMIT},
          {"command", gflags::GetArgv()},
          {"flags", ChangedFlags()},
          {"seed", FLAGS_seed}};
}

void EmitResult(nlohmann::json result, bool write_output) {
  result["planegraph"] = VersionStamp();
  result["seconds"] = SecondsSinceStart();
  if (write_output && !FLAGS_output.empty()) {
    WriteTextFile(FLAGS_output, result.dump(1) + "\n");
  }
  if (FLAGS_json) std::cout << result.dump() << "\n";
}

bool WantsText() { return !FLAGS_json && !FLAGS_quiet; }

}  // namespace planegraph::tools
