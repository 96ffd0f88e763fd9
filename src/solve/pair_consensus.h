#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "planegraph/geometry/sim3.h"

namespace planegraph {

/// A landmark as two nodes see it, each in its own frame.
struct SharedLandmark {
  Eigen::Vector3d target_normal, target_centroid;
  Eigen::Vector3d source_normal, source_centroid;
  double tilt_sigma;    ///< of both normals together, radians
  double offset_sigma;  ///< of both offsets together, metres of the target
};

struct PairConsensusOptions {
  double gate_sigmas = 3.0;
  int rotation_samples = 600, translation_samples = 400;
  bool scale_known = true;  ///< otherwise the source is of unknown scale
  std::uint64_t seed = 0;
};

struct PairConsensus {
  Sim3 target_from_source;
  double widening = 1.0;       ///< of the gate, where the stated deviations are too small
  std::vector<bool> agreeing;  ///< by shared landmark
  int agreeing_count = 0;
  /// Log10 of the chance of its lead over the next best pose that differs, if landmarks preferred
  /// either with equal chance.
  double log10_chance = 0.0;
};

/// The relative pose that most of the shared landmarks agree with; none where no pose agrees with
/// two more than a sample. Stated deviations may be too small: where
/// gates of their width leave it open, 2 and 4 times their width are tried. The best rotations by
/// normals alone come first, then the translation: patches' normals tell a rotation by a degree
/// only, so that all that agree must have had their say on it before offsets in millimetres can.
std::optional<PairConsensus> FindPairConsensus(const std::vector<SharedLandmark>& shared,
                                               const PairConsensusOptions& options);

}  // namespace planegraph
