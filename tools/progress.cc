#include "tools/progress.h"

#include <unistd.h>

#include <atomic>
#include <iostream>
#include <mutex>

#include "tools/common_flags.h"

namespace planegraph::tools {
namespace {

// Of the one command that a process runs.
Heartbeat* heartbeat = nullptr;
std::atomic<bool> is_drawn{false};

}  // namespace

std::unique_ptr<Heartbeat> StartHeartbeat(const std::string& command) {
  if (FLAGS_quiet) return nullptr;
  auto started = std::make_unique<Heartbeat>(std::chrono::seconds(10), [=](const auto& line) {
    if (!is_drawn) std::cerr << "planegraph " + command + ": " + line + "\n" << std::flush;
  });
  heartbeat = started.get();
  return started;
}

Progress ProgressReporter(void (*draw)(const std::string& stage, double done)) {
  if (FLAGS_quiet) return [](const std::string&, double) {};
  if (::isatty(STDERR_FILENO) == 0) {
    return [](const std::string& stage, double done) {
      if (heartbeat != nullptr) heartbeat->Report(stage, done);
    };
  }
  is_drawn = true;
  return [draw, mutex = std::make_shared<std::mutex>()](const std::string& stage, double done) {
    const std::lock_guard<std::mutex> lock(*mutex);
    draw(stage, done);
  };
}

void PrintWarning(const std::string& text) {
  std::cerr << (is_drawn ? "\r\033[K" : "") << "warning: " << text << "\n" << std::flush;
}

}  // namespace planegraph::tools
