#include "sweep/child_process.h"

#include <fcntl.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <chrono>
#include <csignal>
#include <cstring>

#include "planegraph/base/error.h"

namespace planegraph {
namespace {

constexpr int kCannotStart = 127;

// A descriptor that closes itself, here and in every program that is started.
class Descriptor {
 public:
  Descriptor(const std::string& path, int flags) : number_(::open(path.c_str(), flags, 0644)) {
    if (number_ >= 0) return;
    throw InputError::InFile(path, std::string("cannot be written: ") + std::strerror(errno));
  }
  ~Descriptor() { ::close(number_); }
  Descriptor(const Descriptor&) = delete;
  Descriptor& operator=(const Descriptor&) = delete;
  int number() const { return number_; }

 private:
  int number_;
};

// Between fork and exec, where other threads may have held locks: system calls only.
[[noreturn]] void BecomeProgram(char* const* argv, int input, int log, pid_t parent) {
  ::prctl(PR_SET_PDEATHSIG, SIGKILL);
  const bool orphaned = ::getppid() != parent;  // it died before we could ask to die with it
  if (orphaned || ::dup2(input, 0) < 0 || ::dup2(log, 1) < 0 || ::dup2(log, 2) < 0) {
    ::_exit(kCannotStart);
  }
  ::execv(argv[0], argv);
  ::_exit(kCannotStart);
}

double Seconds(const timeval& time) {
  return static_cast<double>(time.tv_sec) + 1e-6 * static_cast<double>(time.tv_usec);
}

ChildResult Wait(pid_t child) {
  int status = 0;
  rusage usage{};
  while (::wait4(child, &status, 0, &usage) < 0 && errno == EINTR) {
  }
  ChildResult result;
  result.signal = WIFSIGNALED(status) ? WTERMSIG(status) : 0;
  result.exit_code = result.signal > 0 ? 128 + result.signal : WEXITSTATUS(status);
  result.cpu_seconds = Seconds(usage.ru_utime) + Seconds(usage.ru_stime);
  result.peak_memory_bytes = 1024.0 * static_cast<double>(usage.ru_maxrss);
  return result;
}

}  // namespace

ChildResult RunChild(const std::vector<std::string>& argv, const std::string& log) {
  const Descriptor input("/dev/null", O_RDONLY | O_CLOEXEC);
  const Descriptor output(log, O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC);
  std::vector<char*> arguments;
  for (const std::string& argument : argv) {
    arguments.push_back(const_cast<char*>(argument.c_str()));
  }
  arguments.push_back(nullptr);
  const pid_t parent = ::getpid();
  const auto start = std::chrono::steady_clock::now();
  const pid_t child = ::fork();
  if (child < 0) throw InputError::InFile(argv[0], std::string("fork: ") + std::strerror(errno));
  if (child == 0) BecomeProgram(arguments.data(), input.number(), output.number(), parent);
  ChildResult result = Wait(child);
  result.wall_seconds =
      std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  return result;
}

}  // namespace planegraph
