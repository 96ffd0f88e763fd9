// The exit codes and messages that scripts rely on, of the built tool itself. The commands and
// their flags are taken from its own help, so that a new command is tried without a word here.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <regex>
#include <set>

#include "cli/tool_runner.h"

namespace planegraph::cli {
namespace {

using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::StartsWith;

bool IsListed(const std::string& command) {
  const auto commands = ListedCommands();
  return std::count(commands.begin(), commands.end(), command) > 0;
}

// One line `error: ...` on stderr and nothing on stdout.
void ExpectOneError(const Outcome& outcome, const std::string& text) {
  EXPECT_THAT(outcome.err, StartsWith("error: "));
  EXPECT_THAT(outcome.err, HasSubstr(text));
  EXPECT_EQ(std::count(outcome.err.begin(), outcome.err.end(), '\n'), 1) << outcome.err;
  EXPECT_THAT(outcome.out, IsEmpty());
}

TEST(Cli, HelpListsTheCommandsAndTheExitCodes) {
  for (const char* arguments : {"", "help", "--help", "-h"}) {
    const Outcome outcome = RunTool(arguments);
    EXPECT_EQ(outcome.exit_code, 0) << arguments;
    EXPECT_THAT(outcome.out, HasSubstr("planegraph COMMAND")) << arguments;
    EXPECT_THAT(outcome.out, HasSubstr("exit codes:")) << arguments;
    EXPECT_THAT(outcome.err, IsEmpty()) << arguments;
  }
}

TEST(Cli, HelpListsTheSimulation) { EXPECT_TRUE(IsListed("simulate")); }

TEST(Cli, VersionIsOneLine) {
  for (const char* arguments : {"version", "--version"}) {
    const Outcome outcome = RunTool(arguments);
    EXPECT_EQ(outcome.exit_code, 0);
    EXPECT_TRUE(std::regex_match(
        outcome.out, std::regex(R"(planegraph \d+\.\d+\.\d+ \(([0-9a-f]{12}|unknown)\)\n)")))
        << outcome.out;
  }
}

TEST(Cli, UnknownCommand) {
  const Outcome outcome = RunTool("no_such_command");
  EXPECT_EQ(outcome.exit_code, 1);
  ExpectOneError(outcome, "no_such_command");
}

TEST(Cli, EveryCommandExplainsItself) {
  for (const auto& command : ListedCommands()) {
    const Outcome outcome = RunTool(command + " --help");
    EXPECT_EQ(outcome.exit_code, 0) << command;
    EXPECT_THAT(outcome.out, StartsWith("planegraph " + command)) << command;
    EXPECT_THAT(outcome.out, HasSubstr("--threads")) << command;
    EXPECT_THAT(outcome.err, IsEmpty()) << command;
  }
}

TEST(Cli, EveryListedFlagIsDefined) {
  for (const auto& command : ListedCommands()) {
    const std::string help = RunTool(command + " --help").out;
    for (const auto& [flag, value] : ListedFlags(command)) {
      EXPECT_THAT(help, HasSubstr("--" + flag + "  ")) << command << " has --" << flag;
    }
  }
}

TEST(Cli, UnknownFlag) {
  for (const auto& command : ListedCommands()) {
    const Outcome outcome = RunTool(command + " --no_such_flag=1");
    EXPECT_EQ(outcome.exit_code, 1) << command;
    EXPECT_THAT(outcome.err, HasSubstr("no_such_flag")) << command;
    EXPECT_THAT(outcome.out, IsEmpty()) << command;
  }
}

// Every flag at two commands that lack it: all pairs would be a thousand runs of the tool.
TEST(Cli, AFlagOfAnotherCommandIsRefused) {
  std::map<std::string, std::string> flags;  // all flags with their defaults
  std::map<std::string, std::set<std::string>> own;
  const auto commands = ListedCommands();
  for (const auto& command : commands) {
    for (const auto& [flag, value] : ListedFlags(command)) {
      flags[flag] = value;
      own[command].insert(flag);
    }
  }
  std::size_t next = 0;
  for (const auto& [flag, value] : flags) {
    const std::string other = value == "true" ? "false" : value == "false" ? "true" : "7";
    int tried = 0;
    for (std::size_t i = 0; i < commands.size() && tried < 2; ++i) {
      const std::string& command = commands[next++ % commands.size()];
      if (own[command].count(flag) > 0) continue;
      ++tried;
      const Outcome outcome = RunTool(command + " --" + flag + "=" + other);
      EXPECT_EQ(outcome.exit_code, 1) << command << " --" << flag;
      ExpectOneError(outcome, "has no flag --" + flag);
    }
  }
}

TEST(Cli, AMistypedFlagOrCommandIsToldWhatItMayHaveMeant) {
  for (const std::string command :
       {"map --outputdir=x site.yaml", "map site.yaml --out x", "map --nooutputdir site.yaml"}) {
    const Outcome outcome = RunTool(command);
    EXPECT_EQ(outcome.exit_code, 1) << command;
    ExpectOneError(outcome, "did you mean --output_dir?");
  }
  const Outcome outcome = RunTool("simulat --scene=hall");
  EXPECT_EQ(outcome.exit_code, 1);
  ExpectOneError(outcome, "did you mean simulate?");
}

TEST(Cli, AFlagWithABadValueIsWrongUsage) {
  for (const auto& command : ListedCommands()) {
    const Outcome outcome = RunTool(command + " --threads=many");
    EXPECT_EQ(outcome.exit_code, 1) << command;
    EXPECT_THAT(outcome.err, HasSubstr("threads")) << command;
  }
}

TEST(Cli, TooManyArgumentsAreWrongUsage) {
  for (const auto& command : ListedCommands()) {
    if (command == "locate") continue;  // takes any number of scans
    EXPECT_EQ(RunTool(command + " a b c d e f g").exit_code, 1) << command;
  }
}

TEST(Cli, AMissingFileIsBadInputAndNamed) {
  const std::pair<const char*, const char*> runs[] = {
      {"map", "missing.yaml --output_dir=out"},
      {"segment", "missing.ply --output=planes.json"},
      {"register", "missing.ply missing.ply --output=out.json"},
      {"convert", "missing.ply out.ply"},
      {"evaluate", "--reference=missing.tum --estimate=missing.tum"},
      {"evaluate", "--map=missing.ply"},
      {"georeference", "--cameras=missing.out --gps=missing.csv"},
  };
  for (const auto& [command, arguments] : runs) {
    if (!IsListed(command)) continue;
    SCOPED_TRACE(command);
    const Outcome outcome = RunTool(std::string(command) + " " + arguments);
    EXPECT_EQ(outcome.exit_code, 2);
    ExpectOneError(outcome, "missing.");
  }
}

}  // namespace
}  // namespace planegraph::cli
