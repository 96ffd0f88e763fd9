// The dispatcher: `planegraph COMMAND [--flags] [ARGS]`, and the one place where errors become exit
// codes.
#include <gflags/gflags.h>
#include <glog/logging.h>
#if __has_include(<malloc.h>)
#include <malloc.h>
#endif

#include <algorithm>
#include <iostream>

#include "planegraph/base/error.h"
#include "planegraph/base/nearest_name.h"
#include "planegraph_version.h"
#include "tools/command.h"
#include "tools/commands.h"
#include "tools/common_flags.h"
#include "tools/flag_text.h"
#include "tools/progress.h"

namespace planegraph::tools {
namespace {

const char* const kCommonFlags[] = {"threads", "seed", "json", "quiet", "log_level", "flagfile"};

void PrintCommands() {
  std::cout << "planegraph COMMAND [--flags] [ARGS]\n\ncommands:\n";
  for (const Command& command : AllCommands()) {
    std::cout << "  " << command.name << std::string(14 - command.name.size(), ' ')
              << command.summary << "\n";
  }
  std::cout << "\n`planegraph COMMAND --help` lists a command's flags.\n"
               "exit codes: 0 done, 1 wrong usage, 2 bad input, 3 no result to rely on, 4 defect\n";
}

void PrintFlag(const std::string& name) {
  gflags::CommandLineFlagInfo info;
  if (!gflags::GetCommandLineFlagInfo(name.c_str(), &info)) return;
  std::cout << "  --" << name << "  " << info.description;
  if (!info.default_value.empty()) {
    std::cout << " [" << FlagText(info.type, info.default_value) << "]";
  }
  std::cout << "\n";
}

void PrintHelp(const Command& command) {
  std::cout << "planegraph " << command.name << " [--flags] " << command.arguments << "\n  "
            << command.summary << "\n\nflags:\n";
  for (const auto& name : command.flags) PrintFlag(name);
  std::cout << "common flags:\n";
  for (const char* name : kCommonFlags) PrintFlag(name);
}

bool Takes(const Command& command, const std::string& flag) {
  return std::count(command.flags.begin(), command.flags.end(), flag) ||
         std::count(std::begin(kCommonFlags), std::end(kCommonFlags), flag);
}

std::string DidYouMean(const std::string& name, const std::string& mark) {
  return name.empty() ? "" : "; did you mean " + mark + name + "?";
}

std::string NoSuchFlag(const Command& command, const std::string& flag) {
  std::vector<std::string> names = command.flags;
  names.insert(names.end(), std::begin(kCommonFlags), std::end(kCommonFlags));
  return "planegraph " + command.name + " has no flag --" + flag +
         DidYouMean(NearestName(flag, names), "--");
}

// Before gflags sees them: it would end the program without a word of what there is.
void RefuseUnknownFlags(const Command& command, int argc, char** argv) {
  for (int i = 1; i < argc && std::string_view(argv[i]) != "--"; ++i) {
    const std::string_view argument = argv[i];
    if (!argument.starts_with("--")) continue;
    const std::string flag(argument.substr(2, argument.find('=') - 2));
    const bool negated = flag.starts_with("no");
    gflags::CommandLineFlagInfo info;
    if (gflags::GetCommandLineFlagInfo(flag.c_str(), &info)) continue;
    if (negated && gflags::GetCommandLineFlagInfo(flag.c_str() + 2, &info)) continue;
    throw UsageError(NoSuchFlag(command, flag));
  }
}

// gflags knows the flags of all commands; one that this command does not take is a mistake, too.
void RefuseForeignFlags(const Command& command) {
  std::vector<gflags::CommandLineFlagInfo> all;
  gflags::GetAllFlags(&all);
  for (const auto& flag : all) {
    const bool ours = flag.filename.find("tools/") != std::string::npos;
    if (ours && !flag.is_default && !Takes(command, flag.name)) {
      throw UsageError(NoSuchFlag(command, flag.name));
    }
  }
}

void StartLogging(const char* program) {
  FLAGS_logtostderr = true;
  FLAGS_minloglevel = FLAGS_quiet ? 2 : FLAGS_log_level;
  google::InitGoogleLogging(program);
}

int RunCommand(const Command& command, int argc, char** argv) {
  const bool wants_help = std::any_of(argv, argv + argc, [](const std::string& argument) {
    return argument == "--help" || argument == "-help" || argument == "-h";
  });
  if (wants_help) return PrintHelp(command), 0;
  RefuseUnknownFlags(command, argc, argv);
  gflags::ParseCommandLineFlags(&argc, &argv, true);
  RefuseForeignFlags(command);
  StartLogging(argv[0]);
  const auto heartbeat = StartHeartbeat(command.name);
  return command.run(std::vector<std::string>(argv + 1, argv + argc));
}

int Fail(int code, const char* what) {
  std::cerr << "error: " << what << std::endl;
  return code;
}

int Dispatch(int argc, char** argv) {
  const std::string name = argc > 1 ? argv[1] : "help";
  if (name == "help" || name == "--help" || name == "-h") return PrintCommands(), 0;
  if (name == "version" || name == "--version") {
    std::cout << "planegraph " << PLANEGRAPH_VERSION << " (" << PLANEGRAPH_COMMIT << ")\n";
    return 0;
  }
  std::vector<std::string> names;
  for (const Command& command : AllCommands()) {
    if (command.name == name) return RunCommand(command, argc - 1, argv + 1);
    names.push_back(command.name);
  }
  throw UsageError("unknown command '" + name + "' (see `planegraph help`)" +
                   DidYouMean(NearestName(name, names), ""));
}

// Keeps what is freed for the next scan, instead of giving it back to the system and asking for it
// again: a tenth of the time of `map` is that of pages that come and go.
void KeepFreedMemory() {
#ifdef __GLIBC__
  constexpr int kLargest = 32 << 20;  // bytes: the most that glibc takes for the first
  mallopt(M_MMAP_THRESHOLD, kLargest);
  mallopt(M_TRIM_THRESHOLD, 8 * kLargest);
#endif
}

int Run(int argc, char** argv) {
  KeepFreedMemory();
  try {
    return Dispatch(argc, argv);
  } catch (const UsageError& error) {
    return Fail(kUsage, error.what());
  } catch (const InputError& error) {
    return Fail(kInput, error.what());
  } catch (const NoResultError& error) {
    return Fail(kNoResult, error.what());
  } catch (const std::exception& error) {
    return Fail(kDefect, error.what());
  }
}

}  // namespace
}  // namespace planegraph::tools

int main(int argc, char** argv) { return planegraph::tools::Run(argc, argv); }
