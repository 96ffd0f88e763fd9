#pragma once

#include <chrono>

namespace planegraph {

/// Seconds from then to now.
inline double SecondsSince(std::chrono::steady_clock::time_point start) {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

/// Adds the seconds of its life to a sum.
class Lap {
 public:
  explicit Lap(double* seconds) : seconds_(seconds) {}
  Lap(const Lap&) = delete;
  Lap& operator=(const Lap&) = delete;
  ~Lap() { *seconds_ += SecondsSince(start_); }

 private:
  double* seconds_;
  std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
};

}  // namespace planegraph
