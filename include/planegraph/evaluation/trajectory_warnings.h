#pragma once

#include <optional>
#include <string>
#include <vector>

#include "planegraph/evaluation/trajectory_error.h"

namespace planegraph {

// Signs that trajectories do not mean what their readers take them for, or that their errors say
// little. Each warning is a sentence; none of them changes a figure.

/// Of one file: how many of its times do not increase, and the first; nothing where all do or it
/// has none.
std::optional<std::string> TimesWarning(const Trajectory& trajectory, const std::string& file);

/// Of one file: times that do not increase, quaternions more than 0.1 % off norm 1, and a first
/// quaternion `1 0 0 0`: the identity with w first, as 3DTK's frames2tum writes it (TUM has w
/// last).
std::vector<std::string> FileWarnings(const Trajectory& trajectory, const std::string& file);

/// Of two files that were paired: many poses without a counterpart, and orientations that agree far
/// better once the four numbers of one file's quaternions are read in another order (w first) or
/// inverted, or both, which is what frames2tum makes of them. Judged on the rotations between
/// poses, which no alignment changes.
std::vector<std::string> PairingWarnings(const Trajectory& reference,
                                         const std::string& reference_file,
                                         const Trajectory& estimate,
                                         const std::string& estimate_file, const PosePairs& pairs);

/// Of the poses' places: too few for the alignment's freedom, nearly on a line, hardly farther
/// apart than their errors, or most of them at one place.
std::vector<std::string> PlacementWarnings(const PosePairs& pairs, const AteResult& ate);

}  // namespace planegraph
