#include "tools/gnuplot.h"

#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cstdio>
#include <cstdlib>
#include <memory>
#include <sstream>

#include "planegraph/base/atomic_file.h"
#include "planegraph/base/error.h"

namespace planegraph::tools {
namespace {

struct CloseFile {
  void operator()(std::FILE* file) const { std::fclose(file); }
};
using TemporaryFile = std::unique_ptr<std::FILE, CloseFile>;

// Files, not pipes: neither side waits for the other.
TemporaryFile MakeTemporary(const std::string& path) {
  TemporaryFile file(std::tmpfile());
  if (!file) throw InputError::InFile(path, "cannot be drawn: no temporary file can be made");
  return file;
}

bool IsOnPath(const std::string& program) {
  const char* path = std::getenv("PATH");
  std::istringstream folders(path ? path : "/usr/bin:/bin");
  for (std::string folder; std::getline(folders, folder, ':');) {
    if (access((folder + "/" + program).c_str(), X_OK) == 0) return true;
  }
  return false;
}

int Run(std::FILE* input, std::FILE* output) {
  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  posix_spawn_file_actions_adddup2(&actions, fileno(input), STDIN_FILENO);
  posix_spawn_file_actions_adddup2(&actions, fileno(output), STDOUT_FILENO);
  char name[] = "gnuplot", dash[] = "-";
  char* arguments[] = {name, dash, nullptr};
  pid_t child = 0;
  const int error = posix_spawnp(&child, name, &actions, nullptr, arguments, environ);
  posix_spawn_file_actions_destroy(&actions);
  int status = -1;
  if (error != 0 || waitpid(child, &status, 0) < 0 || !WIFEXITED(status)) return -1;
  return WEXITSTATUS(status);
}

std::string Content(std::FILE* file) {
  std::rewind(file);
  std::string text;
  char block[65536];
  for (std::size_t n = 0; (n = std::fread(block, 1, sizeof block, file)) > 0;) {
    text.append(block, n);
  }
  return text;
}

}  // namespace

std::string PlotFormat(const std::string& path) {
  if (!path.ends_with(".svg") && !path.ends_with(".pdf")) {
    throw UsageError("--plot ends in .svg or .pdf, unlike '" + path + "'");
  }
  if (!IsOnPath("gnuplot")) {
    throw InputError::InFile(path,
                             "cannot be drawn: the program gnuplot is not installed (Debian: "
                             "package gnuplot-nox)");
  }
  return path.substr(path.size() - 3);
}

void DrawPlot(const std::string& script, const std::string& path) {
  const TemporaryFile input = MakeTemporary(path), output = MakeTemporary(path);
  std::fwrite(script.data(), 1, script.size(), input.get());
  std::fflush(input.get());
  std::rewind(input.get());
  const int code = Run(input.get(), output.get());
  const std::string drawing = Content(output.get());
  if (code != 0 || drawing.empty()) {
    throw InputError::InFile(path, "cannot be drawn: gnuplot ended with " + std::to_string(code));
  }
  WriteTextFile(path, drawing);
}

}  // namespace planegraph::tools
