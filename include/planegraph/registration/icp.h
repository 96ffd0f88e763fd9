#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "planegraph/cloud/cloud.h"
#include "planegraph/geometry/rigid3.h"

namespace planegraph {

struct IcpOptions {
  double voxel_size = 0.1;      ///< metres: both clouds are thinned to this first
  std::size_t neighbours = 12;  ///< for the local shape
  double first_gate = 1.0;      ///< metres: no pair is longer
  double trim = 3.0;            ///< pairs longer than this many times the median are dropped,
  double least_median = 0.1;    ///< where the median counts as at least this, metres
  double max_normal_angle_deg = 30.0;
  int max_iterations = 30;
  double stop = 1e-3;         ///< metres: a smaller step ends it
  double least_sigma = 0.02;  ///< metres: points of one place are not independent; no direction is
                              ///< claimed to be better known
  std::size_t least_pairs = 30;  ///< that must stand against a direction for it to be known
};

struct IcpRefinement {
  Eigen::Vector3d translation;  ///< of target_from_source
  /// Of the translation, 1/m^2: zero outside the open directions and along featureless ones, at
  /// most 1 / least_sigma^2 along the others.
  Eigen::Matrix3d information = Eigen::Matrix3d::Zero();
  std::vector<Eigen::Vector3d> featureless;  ///< unit; open directions that the points cannot tell
  int pairs = 0;
  int iterations = 0;
  bool converged = false;  ///< false also where there was nothing to refine
  std::string reason;      ///< empty, or why a direction stayed where it was
};

/// Refines the translation along the directions that the planes left open (orthonormal, target's
/// axes); rotation and the other directions stay. Thinned clouds, nearest neighbours, trimming,
/// compatible normals; point-to-plane rows where the target is flat, point-to-point rows where it
/// is scattered, none along edges, which would hold a direction that they do not know. Directions
/// along which the normals' own noise would explain the information are not moved at all.
IcpRefinement RefineTranslation(const Cloud& target, const Cloud& source,
                                const Rigid3& target_from_source,
                                const std::vector<Eigen::Vector3d>& open_directions,
                                const IcpOptions& options = {});

}  // namespace planegraph
