#include "planegraph/segmentation/range_image.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace planegraph {

RangeImage::RangeImage(const Cloud& cloud)
    : viewpoint_(cloud.viewpoint - cloud.offset),
      nearest_(kPixels, std::numeric_limits<float>::infinity()),
      farthest_(kPixels, 0.0f) {
  const Eigen::Vector3f centre = viewpoint_.cast<float>();
  for (const auto& p : cloud.points) {
    const Eigen::Vector3f beam = p - centre;
    const int pixel = Pixel(beam);
    const float range = beam.norm();
    nearest_[pixel] = std::min(nearest_[pixel], range);
    farthest_[pixel] = std::max(farthest_[pixel], range);
  }
}

RangeImage::RangeImage(const Eigen::Vector3d& viewpoint, std::vector<float> nearest,
                       std::vector<float> farthest)
    : viewpoint_(viewpoint), nearest_(std::move(nearest)), farthest_(std::move(farthest)) {}

RangeImage::Space RangeImage::Classify(const Eigen::Vector3d& point, double margin) const {
  if (nearest_.empty()) return Space::kUnseen;
  const Eigen::Vector3f beam = (point - viewpoint_).cast<float>();
  const int pixel = Pixel(beam);
  if (farthest_[pixel] == 0.0f) return Space::kUnseen;
  const double range = beam.norm();
  if (range < nearest_[pixel] - margin) return Space::kFree;
  return range > farthest_[pixel] + margin ? Space::kHidden : Space::kSurface;
}

}  // namespace planegraph
