#include "simulation/smooth_field.h"

#include <cmath>

namespace planegraph {
namespace {

// The finalizer of SplitMix64 (Steele et al. 2014).
std::uint64_t Mix(std::uint64_t x) {
  x = (x ^ (x >> 30)) * 0xbf58476d1ce4e5b9ULL;
  x = (x ^ (x >> 27)) * 0x94d049bb133111ebULL;
  return x ^ (x >> 31);
}

std::uint64_t Hash(std::uint64_t seed, std::uint64_t key) {
  return Mix(Mix(seed + 0x9e3779b97f4a7c15ULL) ^ (key * 0xd1342543de82ef95ULL + 1));
}

// The sum of four uniform numbers of 16 bits, made to mean 0 and variance 1.
double NodeValue(std::uint64_t seed, const Eigen::Vector3d& node) {
  std::uint64_t h = seed;
  for (int k = 0; k < 3; ++k) {
    h = Hash(h, static_cast<std::uint64_t>(static_cast<std::int64_t>(node[k])));
  }
  const double sum =
      static_cast<double>((h & 0xffff) + ((h >> 16) & 0xffff) + ((h >> 32) & 0xffff) + (h >> 48));
  return (sum / 65535.0 - 2.0) * 1.7320508075688772;
}

}  // namespace

double HashUniform(std::uint64_t seed, std::uint64_t key) {
  return static_cast<double>(Hash(seed, key) >> 11) * 0x1.0p-53;
}

double SmoothField::operator()(const Eigen::Vector3d& position) const {
  const Eigen::Vector3d scaled = position / length_;
  const Eigen::Vector3d base = scaled.array().floor();
  const Eigen::Array3d t = (scaled - base).array();
  const Eigen::Array3d upper = t * t * (3.0 - 2.0 * t), lower = 1.0 - upper;
  double sum = 0.0, square = 0.0;
  for (int i = 0; i < 8; ++i) {
    const Eigen::Vector3d corner(i & 1, (i >> 1) & 1, i >> 2);
    const double weight =
        (i & 1 ? upper : lower).x() * (i & 2 ? upper : lower).y() * (i & 4 ? upper : lower).z();
    sum += weight * NodeValue(seed_, base + corner);
    square += weight * weight;
  }
  return sum / std::sqrt(square);
}

}  // namespace planegraph
