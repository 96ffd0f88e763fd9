#include "pipeline/camera_sides.h"

#include <cmath>

#include "planegraph/base/parallel.h"

namespace planegraph {

void OrientByCameras(const std::vector<Eigen::Vector3d>& centres, int threads, PlaneSet* planes) {
  constexpr double kMajority = 0.5;
  ParallelFor(planes->patches.size(), threads, [&](std::size_t i) {
    Patch& patch = planes->patches[i];
    double facing = 0.0, total = 0.0;
    for (const Eigen::Vector3d& centre : centres) {
      const Eigen::Vector3d to_camera = centre - patch.moments.mean;
      const double distance = to_camera.norm();
      if (!(distance > 0.0)) continue;
      const double share = patch.normal.dot(to_camera) / (distance * distance * distance);
      facing += share;
      total += std::abs(share);
    }
    if (!(total > 0.0 && std::abs(facing) >= kMajority * total)) return;
    if (facing < 0.0) patch.normal = -patch.normal;
    patch.orientation = Orientation::kSensor;
  });
}

}  // namespace planegraph
