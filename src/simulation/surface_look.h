#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>

#include "planegraph/simulation/photogrammetry.h"
#include "planegraph/simulation/ray_caster.h"
#include "simulation/smooth_field.h"

namespace planegraph {

/// What the surfaces of a scene look like to a camera: procedural, by the seed.
class SurfaceLook {
 public:
  SurfaceLook(const PhotogrammetryOptions& options, std::uint64_t seed);

  /// The share of depths at a place that have enough texture to be measured.
  double KeptShare(const RayCaster::Hit& hit, const Eigen::Vector3d& x_in_world) const;
  std::array<std::uint8_t, 3> Color(const RayCaster::Hit& hit,
                                    const Eigen::Vector3d& x_in_world) const;

 private:
  const PhotogrammetryOptions& options_;
  std::uint64_t seed_;
  SmoothField holes_, coarse_, fine_;
  double hole_threshold_;
};

}  // namespace planegraph
