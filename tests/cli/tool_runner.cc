#include "cli/tool_runner.h"

#include <sys/wait.h>
#include <unistd.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <regex>
#include <sstream>

namespace planegraph::cli {
namespace {

namespace fs = std::filesystem;

std::string ReadAll(const fs::path& path) {
  std::ifstream stream(path);
  return {std::istreambuf_iterator<char>(stream), {}};
}

// The lines of `text` between the line `from` and the next line that is empty or equals `to`.
std::vector<std::string> Section(const std::string& text, const std::string& from,
                                 const std::string& to) {
  std::vector<std::string> lines;
  std::istringstream stream(text);
  bool inside = false;
  for (std::string line; std::getline(stream, line);) {
    if (inside && (line.empty() || line == to)) break;
    if (inside) lines.push_back(line);
    if (line == from) inside = true;
  }
  return lines;
}

}  // namespace

Outcome RunTool(const std::string& arguments) {
  const fs::path folder =
      fs::temp_directory_path() / ("planegraph_cli_" + std::to_string(getpid()));
  fs::create_directories(folder);
  const std::string command = "cd " + folder.string() + " && " + PLANEGRAPH_TOOL + " " + arguments +
                              " >stdout.txt 2>stderr.txt </dev/null";
  const int status = std::system(command.c_str());
  Outcome outcome;
  outcome.exit_code = WIFEXITED(status) ? WEXITSTATUS(status) : -1;
  outcome.out = ReadAll(folder / "stdout.txt");
  outcome.err = ReadAll(folder / "stderr.txt");
  fs::remove_all(folder);
  return outcome;
}

std::vector<std::string> ListedCommands() {
  std::vector<std::string> commands;
  for (const auto& line : Section(RunTool("help").out, "commands:", "")) {
    std::istringstream words(line);
    commands.emplace_back();
    words >> commands.back();
  }
  return commands;
}

std::vector<std::pair<std::string, std::string>> ListedFlags(const std::string& command) {
  static const std::regex kFlag(R"(\s*--(\w+)(?:.*\[(.*)\])?.*)");
  std::vector<std::pair<std::string, std::string>> flags;
  std::smatch match;
  for (const auto& line : Section(RunTool(command + " --help").out, "flags:", "common flags:")) {
    if (std::regex_match(line, match, kFlag)) flags.emplace_back(match[1], match[2]);
  }
  return flags;
}

}  // namespace planegraph::cli
