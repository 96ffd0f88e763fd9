#include "planegraph/base/heartbeat.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace planegraph {

Heartbeat::Heartbeat(Clock::duration interval, std::function<void(const std::string&)> say)
    : interval_(interval), say_(std::move(say)), thread_([this] { Beat(); }) {}

Heartbeat::~Heartbeat() {
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    stopped_ = true;
  }
  stop_.notify_all();
  thread_.join();
}

void Heartbeat::Report(const std::string& stage, double done) {
  const std::lock_guard<std::mutex> lock(mutex_);
  const double percent = std::floor(100.0 * std::clamp(done, 0.0, 1.0));
  stage_ = stage + " " + std::to_string(static_cast<int>(percent)) + " %";
  if (Clock::now() - last_ >= interval_) Say();
}

void Heartbeat::Beat() {
  std::unique_lock<std::mutex> lock(mutex_);
  while (!stop_.wait_until(lock, last_ + interval_, [this] { return stopped_; })) {
    if (Clock::now() - last_ >= interval_) Say();
  }
}

void Heartbeat::Say() {
  last_ = Clock::now();
  const auto seconds = std::chrono::duration_cast<std::chrono::seconds>(last_ - start_).count();
  say_(stage_ + ", " + std::to_string(seconds) + " s");
}

}  // namespace planegraph
