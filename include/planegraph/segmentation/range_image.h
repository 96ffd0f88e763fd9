#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <limits>
#include <vector>

#include "planegraph/cloud/cloud.h"

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
    const Eigen::Vector3f size = direction.cwiseAbs();
    // Selections rather than branches: the faces of successive beams are hard to foresee.
    const bool x_first = size.x() >= size.y() && size.x() >= size.z();
    const bool y_first = size.y() >= size.z();
    const float w = x_first ? size.x() : y_first ? size.y() : size.z();
    const float main = x_first ? direction.x() : y_first ? direction.y() : direction.z();
    const float u = x_first ? direction.y() : direction.x();
    const float v = !x_first && !y_first ? direction.y() : direction.z();
    if (!(w > 0)) return 0;
    const int face = 2 * (x_first ? 0 : y_first ? 1 : 2) + (main > 0 ? 0 : 1);
    const float scale = 0.5f * kEdge / w;
    const int i = std::clamp(static_cast<int>(u * scale + 0.5f * kEdge), 0, kEdge - 1);
    const int j = std::clamp(static_cast<int>(v * scale + 0.5f * kEdge), 0, kEdge - 1);
    return (face * kEdge + j) * kEdge + i;
  }

  Eigen::Vector3d viewpoint_ = Eigen::Vector3d::Zero();
  std::vector<float> nearest_, farthest_;
};

}  // namespace planegraph
