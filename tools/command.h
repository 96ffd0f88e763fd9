#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

namespace planegraph::tools {

/// Exit codes beside 0: a wrong call, a wrong input, no result that may be believed, our own
/// defect.
inline constexpr int kUsage = 1, kInput = 2, kNoResult = 3, kDefect = 4;

/// One subcommand. It lives in a file of its own, tools/NAME.cc, that defines its gflags and a
/// `Command NAMECommand()`; main.cc lists them.
struct Command {
  std::string name;
  std::string arguments;           ///< the positional arguments, as the usage line shows them
  std::string summary;             ///< one line for `planegraph help`
  std::vector<std::string> flags;  ///< the flags it takes beside the common ones
  /// Does the work and returns the exit code. Errors are thrown (base/error.h).
  int (*run)(const std::vector<std::string>& arguments);
};

/// Stops with UsageError unless the number of arguments lies in [least, most].
void ExpectArguments(const std::vector<std::string>& arguments, std::size_t least,
                     std::size_t most);
/// Stops with UsageError where the flag NAME has no value.
void RequireFlag(const std::string& name);

/// Completes a result with `planegraph` (version, commit, command, flags, seed) and `seconds`,
/// writes it to --output where `write_output` is set and the flag given, and to stdout with --json.
void EmitResult(nlohmann::json result, bool write_output);

/// The flags with their values, one a line, as --flagfile reads them: `flags` and the common ones
/// that decide on the result.
std::string FlagFile(std::vector<std::string> flags);

/// Seconds since the program started.
double SecondsSinceStart();
/// The version stamp that every JSON result carries.
nlohmann::json VersionStamp();
/// True where the user wants prose on stdout: neither --json nor --quiet.
bool WantsText();

}  // namespace planegraph::tools
