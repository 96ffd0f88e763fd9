#pragma once

#include <Eigen/Core>
#include <cstdint>

namespace planegraph {

/// A number in [0, 1) that looks random and depends on the two keys alone.
double HashUniform(std::uint64_t seed, std::uint64_t key);

/// A smooth random function of the place with mean 0 and variance 1: nearly normal values on the
/// nodes of a grid of the edge `length` (metres), interpolated in between. Values farther apart
/// than two lengths are independent. Costs no memory and may be asked anywhere, by many threads.
class SmoothField {
 public:
  SmoothField(std::uint64_t seed, double length) : seed_(seed), length_(length) {}
  double operator()(const Eigen::Vector3d& position) const;

 private:
  std::uint64_t seed_;
  double length_;
};

}  // namespace planegraph
