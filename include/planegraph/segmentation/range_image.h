#pragma once

#include <Eigen/Core>
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

  bool empty() const { return nearest_.empty(); }
  const Eigen::Vector3d& viewpoint() const { return viewpoint_; }
  /// Metres; infinity and 0 in pixels without a return.
  const std::vector<float>& nearest() const { return nearest_; }
  const std::vector<float>& farthest() const { return farthest_; }

  static constexpr int kEdge = 64;  ///< pixels along the edge of a face: 1.4 degrees
  static constexpr std::size_t kPixels = 6 * kEdge * kEdge;

 private:
  static int Pixel(const Eigen::Vector3f& direction);

  Eigen::Vector3d viewpoint_ = Eigen::Vector3d::Zero();
  std::vector<float> nearest_, farthest_;
};

}  // namespace planegraph
