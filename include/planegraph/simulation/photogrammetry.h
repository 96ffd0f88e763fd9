#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "planegraph/cloud/cloud.h"
#include "planegraph/geometry/rigid3.h"
#include "planegraph/geometry/sim3.h"
#include "planegraph/simulation/flight.h"
#include "planegraph/simulation/ray_caster.h"

namespace planegraph {

/// What a multi-view stereo program makes of a flight's images, without rendering them: depths of
/// pixels with the errors that such depths have.
///
/// A depth Z (along the camera's axis) that is measured with a baseline b across the ray has the
/// standard deviation Z^2 disparity_sigma / (f b), f in pixels. The baseline is that of the
/// farthest of the nearest `neighbours` cameras that sees the point, too, under an angle of at most
/// max_angle. The error has a part that all images share (texture and regularization are the same),
/// one of the image, both smooth over `correlation_length`, and a white one.
struct PhotogrammetryOptions {
  int pixel_step = 13;           ///< one depth per square of so many pixels; 1 to 480
  double disparity_sigma = 0.5;  ///< pixels
  double surface_share = 0.4, image_share = 0.4;  ///< of the variance; the rest is white
  double correlation_length = 0.6;                ///< metres
  int neighbours = 16;                            ///< cameras asked for a second view
  double max_angle = 0.55;                        ///< between the two rays, radians
  double min_cosine = 0.2;                        ///< of the incidence angle in both views
  double max_range = 90.0;                        ///< metres
  double max_sigma = 0.35;                        ///< of a depth that is kept, metres

  /// Smoothing: the inverse depth is blended with its mean over two opposite pixels up to `window`
  /// away, by the share `smoothing`. That leaves planes as they are and blurs edges. Where the
  /// depth jumps by more than edge_gap (metres), the point is kept as it is or lost, half and half.
  double window = 5.0, smoothing = 0.7, edge_gap = 1.5;

  /// Texture: a share poor_planes of the upright planes keeps only poor_kept of its points, and the
  /// share hole_share of the surface, in patches of about hole_size metres, only a tenth.
  double poor_planes = 0.1, poor_kept = 0.12, hole_share = 0.05, hole_size = 2.0;
  double outlier_share = 0.002, outlier_sigma = 1.5;  ///< errors of the depth, metres
  double normal_sigma = 0.09;                         ///< each axis, radians

  /// The whole model (points and cameras) is bent like a bowl: at the edge of the flight it is up
  /// or down by 0.5 to 1.5 times this share of the flight's half extent, against its middle.
  double bowl = 0.002;
  double unregistered_share = 0.03;  ///< cameras that the program could not place
  /// Errors of the placed cameras, each axis, metres and radians.
  double position_sigma = 0.02, rotation_sigma = 0.0005;
  double min_scale = 6.0, max_scale = 11.0;  ///< metres per unit of the model

  /// The same points, exactly on their surfaces, and exact cameras; the model's frame stays.
  PhotogrammetryOptions WithoutNoise() const;
};

/// A model in its own frame (`map`): x_world = scale R x_map + t. Entry i of each list belongs to
/// point i.
struct PhotogrammetryModel {
  Sim3 world_from_map;              ///< metres from units of the model, the bowl left aside
  Cloud cloud;                      ///< units of the model; normals point to the cameras; colours
  std::vector<int> labels;          ///< the plane; kNotPlanar also where an edge was blurred
  std::vector<std::int32_t> views;  ///< the image whose depth it is
  std::vector<float> sigmas;        ///< standard deviation along that image's ray, metres
  std::vector<float> spacings;      ///< distance of two depths on the surface, units of the model
  /// Poses of the cameras with lengths in units of the model; none: not registered.
  std::vector<std::optional<Rigid3>> map_from_camera;
};

/// The model of a flight over a scene. The result is the same for every number of threads. Throws
/// UsageError for options that make no sense.
PhotogrammetryModel Reconstruct(const RayCaster& caster, const Flight& flight,
                                const PhotogrammetryOptions& options, std::uint64_t seed,
                                int threads);

}  // namespace planegraph
