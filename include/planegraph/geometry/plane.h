#pragma once

#include <Eigen/Core>

#include "planegraph/geometry/rigid3.h"

namespace planegraph {

/// An oriented plane: points p with normal . p = distance, |normal| = 1. Laser planes point towards
/// the scanner.
struct Plane {
  Eigen::Vector3d normal = Eigen::Vector3d::UnitZ();
  double distance = 0.0;

  double SignedDistance(const Eigen::Vector3d& point) const { return normal.dot(point) - distance; }
  Plane Flipped() const { return {-normal, -distance}; }
};

/// The plane seen from the target's frame.
inline Plane Transform(const Rigid3& target_from_source, const Plane& plane) {
  const Eigen::Vector3d normal = target_from_source.rotation * plane.normal;
  return {normal, plane.distance + normal.dot(target_from_source.translation)};
}

}  // namespace planegraph
