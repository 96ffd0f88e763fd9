#pragma once

#include <Eigen/Core>
#include <vector>

#include "planegraph/correspondence/patch_map.h"

namespace planegraph {

/// What a drone saw through to get at the ground: above the highest surface of a column that faces
/// up, the air is free. Which way is up follows from the surfaces: grounds and roofs add up, walls
/// cancel out. Tells a place where the map knows that nothing stands from one that it never saw,
/// which hits and misses cannot.
class OpenSky {
 public:
  explicit OpenSky(const std::vector<Surfel>& surfels);

  /// False where nobody knows which way the surfaces face: nothing is open then.
  bool known() const { return !highest_.empty(); }
  /// Unit, map's frame; zero where it is not known.
  Eigen::Vector3d up() const { return columns_from_map_.row(2); }
  /// Whether the air at a place (map's frame, metres) is known to be free.
  bool Free(const Eigen::Vector3d& point) const;
  /// Whether a surface at a place, facing so, stands in the open: the drone would have seen it, its
  /// top or its foot.
  bool Open(const Eigen::Vector3d& point, const Eigen::Vector3d& normal) const;

 private:
  long Column(const Eigen::Vector3d& point) const;
  void Mark(const Surfel& surfel);

  Eigen::Matrix3d columns_from_map_;  // rotation: up becomes z
  double cell_ = 0.0;                 // metres
  Eigen::Vector2d low_ = Eigen::Vector2d::Zero();
  long width_ = 0, height_ = 0;
  std::vector<float> highest_;  // -infinity: nothing faces up there
};

}  // namespace planegraph
