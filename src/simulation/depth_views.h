#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <vector>

#include "planegraph/simulation/photogrammetry.h"
#include "simulation/smooth_field.h"
#include "simulation/surface_look.h"

namespace planegraph {

/// A depth that stereo measured, as a point of the world frame.
struct DepthPoint {
  Eigen::Vector3d position, normal;  ///< with their errors
  double sigma = 0.0;                ///< along the ray, metres
  double spacing = 0.0;              ///< to the next depth on the surface, metres
  int label = kNotPlanar, view = 0;
  std::array<std::uint8_t, 3> color{};
};

/// The depths of each image of a flight.
class DepthViews {
 public:
  /// `used`: the images that have a place in the model. All arguments have to outlive the object.
  DepthViews(const RayCaster& caster, const Flight& flight, const PhotogrammetryOptions& options,
             const std::vector<bool>& used, std::uint64_t seed);

  /// The depths of one image, none where it is not used.
  std::vector<DepthPoint> Measure(int view) const;

 private:
  struct Pixel {
    Eigen::Vector3d ray;  ///< camera frame, z = 1
    std::optional<RayCaster::Hit> hit;
    double depth = 0.0;  ///< along the camera's axis
  };
  struct Grid {
    int columns = 0, rows = 0;
    std::vector<Pixel> pixels;
  };

  Pixel Look(int view, const Eigen::Vector2d& pixel) const;
  Grid LookAtGrid(int view, Random* random) const;
  bool IsAtEdge(const Grid& grid, int column, int row) const;
  std::optional<double> Baseline(int view, const Pixel& pixel, const Eigen::Vector3d& point) const;
  bool Sees(int view, const Eigen::Vector3d& point) const;
  std::optional<double> SmoothedDepth(int view, const Pixel& pixel, Random* random) const;
  std::optional<DepthPoint> MeasurePixel(int view, const Pixel& pixel, bool at_edge,
                                         Random* random) const;
  double DepthError(int view, const Eigen::Vector3d& point, double sigma, Random* random) const;

  const RayCaster& caster_;
  const Flight& flight_;
  const PhotogrammetryOptions& options_;
  std::uint64_t seed_;
  SurfaceLook look_;
  SmoothField surface_error_;
  std::vector<std::vector<int>> neighbours_;  ///< of each image, the farthest first; empty: unused
};

}  // namespace planegraph
