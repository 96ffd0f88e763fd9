#pragma once

#include <chrono>
#include <condition_variable>
#include <functional>
#include <mutex>
#include <string>
#include <thread>

namespace planegraph {

/// A sign of life of long work: while it lives, a line at most every `interval` and, once the work
/// lasts that long, at least one in each. Work that is done sooner says nothing.
class Heartbeat {
 public:
  using Clock = std::chrono::steady_clock;

  /// `say` gets each line, "registration 50 %, 20 s" or "at work, 20 s" before the first report,
  /// the seconds counted from the construction. It is called from any thread, one at a time.
  Heartbeat(Clock::duration interval, std::function<void(const std::string&)> say);
  ~Heartbeat();
  Heartbeat(const Heartbeat&) = delete;
  Heartbeat& operator=(const Heartbeat&) = delete;

  /// The stage that the work is in and the share of it, in [0, 1], that is done. From any thread.
  void Report(const std::string& stage, double done);

 private:
  void Beat();
  void Say();  // with the lock held

  const Clock::duration interval_;
  const std::function<void(const std::string&)> say_;
  const Clock::time_point start_ = Clock::now();
  Clock::time_point last_ = start_;
  std::string stage_ = "at work";
  std::mutex mutex_;
  std::condition_variable stop_;
  bool stopped_ = false;
  std::thread thread_;
};

}  // namespace planegraph
