#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "planegraph/cloud/cloud.h"
#include "planegraph/geometry/cube_side.h"

namespace planegraph {

/// What the sensor saw in each direction: on the faces of a cube about the viewpoint, the nearest
/// and the farthest range of the points in each pixel. It tells free space: a beam passed through
/// everything nearer than the nearest return.
class RangeImage {
 public:
  RangeImage() = default;
  explicit RangeImage(const Cloud& cloud);
  /// From the values that the accessors give; both lists hold kPixels of them.
  RangeImage(const Eigen::Vector3d& viewpoint, std::vector<float> nearest,
             std::vector<float> farthest);

  enum class Space { kUnseen, kFree, kSurface, kHidden };
  /// What is known about a place (cloud's frame less the offset), with `margin` metres of
  /// tolerance.
  Space Classify(const Eigen::Vector3d& point, double margin) const;
  /// Whether that is kFree.
  bool IsFree(const Eigen::Vector3d& point, double margin) const {
    if (nearest_.empty()) return false;
    const Eigen::Vector3f beam = (point - viewpoint_).cast<float>();
    const float nearest = nearest_[Pixel(beam)];  // infinite where nothing was seen
    return nearest <= kFarthest && beam.norm() < nearest - margin;
  }

  bool empty() const { return nearest_.empty(); }
  const Eigen::Vector3d& viewpoint() const { return viewpoint_; }
  /// Metres; infinity and 0 in pixels without a return.
  const std::vector<float>& nearest() const { return nearest_; }
  const std::vector<float>& farthest() const { return farthest_; }

  static constexpr int kEdge = 64;  ///< pixels along the edge of a face: 1.4 degrees
  static constexpr std::size_t kPixels = 6 * kEdge * kEdge;

 private:
  static constexpr float kFarthest = std::numeric_limits<float>::max();

  static int Pixel(const Eigen::Vector3f& direction) {
    const int side = CubeSide(direction);
    const bool x_first = side < 2, z_first = side >= 4;
    const float w = std::abs(x_first ? direction.x() : z_first ? direction.z() : direction.y());
    const float u = x_first ? direction.y() : direction.x();
    const float v = z_first ? direction.y() : direction.z();
    if (!(w > 0)) return 0;
    const float scale = 0.5f * kEdge / w;
    const int i = std::clamp(static_cast<int>(u * scale + 0.5f * kEdge), 0, kEdge - 1);
    const int j = std::clamp(static_cast<int>(v * scale + 0.5f * kEdge), 0, kEdge - 1);
    return (side * kEdge + j) * kEdge + i;
  }

  Eigen::Vector3d viewpoint_ = Eigen::Vector3d::Zero();
  std::vector<float> nearest_, farthest_;
};

}  // namespace planegraph
