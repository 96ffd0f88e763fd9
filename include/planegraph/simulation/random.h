#pragma once

#include <cstdint>
#include <random>

namespace planegraph {

/// Random numbers that are the same everywhere: std::mt19937_64 is fixed by the C++ standard, and
/// the transforms are our own, since those of `random` differ between standard libraries. Each part
/// of a simulation draws from a stream of its own, so that no part changes the numbers of another
/// one and the work can be shared among threads. Draw once per statement, or in braces: C++ leaves
/// the order of operands and of a call's arguments to the compiler.
class Random {
 public:
  explicit Random(std::uint64_t seed, std::uint64_t stream = 0);

  /// In [0, 1), with 53 random bits.
  double Uniform();
  /// In [low, high).
  double Uniform(double low, double high);
  /// Standard normal (Box and Muller 1958).
  double Normal();
  /// In [0, count), for small counts.
  int Index(int count);
  /// True in a share `probability` of the calls.
  bool Chance(double probability) { return Uniform() < probability; }
  /// -1 or 1.
  double Sign() { return Chance(0.5) ? 1.0 : -1.0; }

 private:
  std::mt19937_64 engine_;
};

}  // namespace planegraph
