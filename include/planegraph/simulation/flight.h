#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "planegraph/geometry/rigid3.h"
#include "planegraph/simulation/random.h"

namespace planegraph {

/// A camera without distortion. Camera frame: x right, y down, z forward. Pixel (u, v), corners of
/// the image at (0, 0) and (width, height): u = f x / z + width / 2, v = f y / z + height / 2.
struct PinholeCamera {
  int width = 640, height = 480;  ///< pixels
  double focal = 0.71875;         ///< focal length in units of the image's width

  double FocalPixels() const { return focal * width; }
  /// The direction of a pixel in the camera frame, with z = 1.
  Eigen::Vector3d Direction(const Eigen::Vector2d& pixel) const;
  /// The pixel of a point; none where the point lies behind the camera or outside the image.
  std::optional<Eigen::Vector2d> Project(const Eigen::Vector3d& x_in_camera) const;
};

/// How a drone takes its images: first parallel lines over the area, looking down and somewhat
/// ahead, then a ring around it and another one half as large as the area, looking at its middle.
struct FlightOptions {
  PinholeCamera camera;
  double height = 22.0;         ///< of the lines above the world's zero, metres
  double overlap_along = 0.8;   ///< of successive images' footprints on a line, in [0, 1)
  double overlap_across = 0.7;  ///< of the footprints on neighbouring lines, in [0, 1)
  double line_pitch = 0.25;     ///< how far the lines' images look ahead of straight down, radians
  int ring_images = 48;         ///< on the outer ring, at even angles; 0: no ring
  int inner_ring_images = 32;   ///< its images show the facades beyond the middle
  double ring_height = 15.0;    ///< of both above the world's zero, metres
  double ring_margin = 12.0;    ///< of the outer one from the area's edge outwards, metres
  double target_height = 2.0;   ///< of the point in the rings' images' middle, metres
  double speed = 2.0;           ///< metres per second
  double start_time = 200.0;    ///< seconds
  double position_sigma = 0.3;  ///< of each image's place against the plan, each axis, metres
  double tilt_sigma = 0.05;     ///< of each image's direction, each axis, radians
};

/// A flight as it was. Entry k of each list belongs to image k.
struct Flight {
  PinholeCamera camera;
  std::vector<double> times;              ///< seconds, increasing
  std::vector<Rigid3> world_from_camera;  ///< metres
};

/// A flight over the rectangle between two corners. Throws UsageError for options that make no
/// sense, more than 5000 images among them.
Flight PlanFlight(const Eigen::Vector2d& low, const Eigen::Vector2d& high,
                  const FlightOptions& options, Random* random);

}  // namespace planegraph
