#pragma once

#include <cstdint>
#include <vector>

#include "planegraph/graph/graph.h"

namespace planegraph {

struct JointInitializationOptions {
  /// An observation agrees with its landmark, and a shared landmark with a relative pose, within so
  /// many standard deviations of its own tilt and offset.
  double gate_sigmas = 3.0;
  int rotation_samples = 600;     ///< pairs of shared landmarks tried for a relative rotation
  int translation_samples = 400;  ///< triples (with a map: quadruples) for a translation
  std::uint64_t seed = 0;
};

struct JointInitialization {
  /// agreeing[k][o]: observation o of landmark k agrees with the poses found.
  std::vector<std::vector<bool>> agreeing;
  /// Which poses and maps hang together by shared landmarks or relative poses; a component's number
  /// is its smallest member, poses before maps. Between components nothing is known.
  std::vector<int> pose_component, map_component;

  /// All poses and maps with an observation are in one component.
  bool one_component = false;
  /// Log10 of the chance of the least sure step: -3 or less where all of them were sure, near 0
  /// where something was placed by a guess that had a rival.
  double least_sure_log10_chance = 0.0;
};

/// Poses, maps and planes of a graph from no guess at all, where it is known which observations are
/// of one plane; more than half of that knowledge may be wrong. The graph's poses are not read but
/// for the gauge: the fixed pose (else the first one) of each component stays.
///
/// 1. Parts grow together, at first each node by itself: relative rotation, then translation (and
///    scale, where one is a map) of every two by consensus over small samples, with the chance of
///    the best pose's lead over the next one; the surest two join. What all nodes of a part agree
///    on finds the wrong observations of the next, so that every join makes the others surer.
/// 2. After each join, in turn and with narrowing gates: the observations of each landmark that
/// agree; all rotations at
///    once from their normals (chordal relaxation: one linear system, landmarks eliminated, each
///    projected to SO(3)); then all translations, scales and offsets at once, which is linear.
///
/// After Surmann et al.'s split of rotation and translation, its two-node case, and Carlone et al.
/// (ICRA 2015) for the chordal form. Normals of one landmark must point to one side. Measurements
/// of absolute place (GPS, priors) are left to the solver. Returns the verdicts; throws
/// std::invalid_argument for a graph that is not valid.
JointInitialization InitializeJointly(Graph* graph, const JointInitializationOptions& options = {});

}  // namespace planegraph
