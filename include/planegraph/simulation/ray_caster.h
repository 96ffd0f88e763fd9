#pragma once

#include <Eigen/Core>
#include <memory>
#include <optional>

#include "planegraph/simulation/labelled_mesh.h"

namespace planegraph {

/// Finds what a ray hits first in a mesh (copied). Backed by Embree. On labelled triangles the
/// distance is that of the exact plane in double precision. Const calls may run at the same time.
class RayCaster {
 public:
  explicit RayCaster(const LabelledMesh& mesh);
  ~RayCaster();
  RayCaster(RayCaster&&) noexcept;

  struct Hit {
    double distance = 0.0;  ///< metres along the ray
    double cosine = 0.0;    ///< of the incidence angle, in [0, 1]
    int label = kNotPlanar;
    Eigen::Vector3d normal = Eigen::Vector3d::UnitZ();  ///< of the surface, towards the origin
  };
  /// The first hit within `max_distance`; `direction` has unit length.
  std::optional<Hit> Cast(const Eigen::Vector3d& origin, const Eigen::Vector3d& direction,
                          double max_distance) const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace planegraph
