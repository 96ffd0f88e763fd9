#pragma once

#include <cstdint>
#include <vector>

#include "registration/georeference_pairs.h"

namespace planegraph {

/// A similarity that stands against outliers, and the noise it leaves (metres, per axis).
struct RobustFit {
  Sim3 world_from_map;
  double sigma_horizontal = 0.0, sigma_vertical = 0.0;
  std::vector<bool> inlier;  ///< one per pair
};

/// What is known of the noise beforehand.
struct NoisePrior {
  /// Positions by GPS have weaker heights; metric ones have no axis of their own.
  bool vertical_differs = true;
  double vertical_ratio() const { return vertical_differs ? 2.0 : 1.0; }
};

/// Three-point samples (all triples where they are few), the one with the least median residual;
/// then Cauchy-weighted Gauss-Newton, the noise measured anew from medians in each round. Needs
/// three pairs.
RobustFit FitRobustly(const std::vector<PositionPair>& pairs, const NoisePrior& prior,
                      std::uint64_t seed, int samples);

/// The least noise that is believed, metres: rounding of positions in files.
double NoiseFloor(const std::vector<PositionPair>& pairs, const Sim3& world_from_map);

}  // namespace planegraph
