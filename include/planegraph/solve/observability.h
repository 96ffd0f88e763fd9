#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

namespace planegraph {

enum class MotionKind { kTranslation, kRotation, kScale, kEverything };
/// "translation", "rotation", "scale", "everything".
std::string Name(MotionKind kind);

/// A motion of a graph's nodes (its poses, then its maps) that the planes do not observe, or
/// hardly: one entry for all nodes that share it.
struct OpenMotion {
  MotionKind kind = MotionKind::kTranslation;
  /// World axes, orthonormal, of a translation or rotation: any motion within them is open.
  std::vector<Eigen::Vector3d> axes;
  /// Nodes that keep their place in a part relative to each other; the parts move freely against
  /// each other. The first one is the larger rest of the graph. A single part: every step is
  /// observed, and yet the errors add up to more than what counts as observed.
  std::vector<std::vector<int>> parts;
  int degrees_of_freedom = 0;  ///< of the parts against each other
  double sigma_planes = 0.0;  ///< by planes alone, of the node that is known least; may be infinite
  double sigma = 0.0;         ///< with all that is known (m, rad, or relative); may be infinite
  std::string held_by;        ///< what holds it most: odometry, gps, ...; empty: nothing
  int node = 0, reference = 0;  ///< the node of these sigmas, and to which they are relative
};

/// "translation along (0.71, 0.70, 0.01)", "scale".
std::string InWords(const OpenMotion& motion);

}  // namespace planegraph
