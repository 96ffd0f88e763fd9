#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "planegraph/geometry/sim3.h"
#include "planegraph/io/camera_io.h"
#include "planegraph/io/gps_io.h"

namespace planegraph {

using Matrix7d = Eigen::Matrix<double, 7, 7>;

struct GeoreferenceOptions {
  /// `robust`: a similarity by random samples and a robust, correlation-aware fit. `paper`: the
  /// nearest fix for each camera, scale by the ratio of the mean distances of adjacent positions,
  /// then a rigid alignment (Surmann, Berninger and Worst); kept for comparison. Its covariance is
  /// what least squares would have under white noise: it knows nothing of the method's bias.
  std::string method = "robust";
  std::optional<GeodeticPosition>
      origin;                        ///< of the world's east-north-up frame; first fix if none
  std::uint64_t seed = 0;            ///< of the random samples
  double max_gap = 5.0;              ///< seconds: no interpolation between fixes further apart
  double max_time_offset = 20.0;     ///< seconds: offsets of the clocks looked for; 0: none
  double max_sigma_scale = 0.1;      ///< relative: above it the result is degenerate
  double max_sigma_rotation = 0.17;  ///< radians, likewise
};

/// A camera with the position that GPS gives it.
struct CameraFix {
  std::size_t camera = 0;  ///< row of the camera file
  Eigen::Vector3d centre_in_map = Eigen::Vector3d::Zero();
  Eigen::Vector3d position_in_world = Eigen::Vector3d::Zero();
  bool inlier = false;
};

/// Metric scale and pose of a photogrammetric model. The world is the east-north-up frame at
/// `origin`, or the frame of the metric positions. A constant bias of the receiver (metres, with
/// one receiver) cannot be seen in its own positions: it stays in the world frame and is not part
/// of the covariance.
struct Georeference {
  std::string status = "failed";  ///< ok, degenerate, failed
  std::string reason;             ///< in words, where the status is not ok
  bool has_estimate = false;      ///< false: the fields below but `origin`, `fixes` mean nothing
  Sim3 world_from_map;
  /// Order x y z rx ry rz log(scale), metres and radians: decoupled left perturbation
  /// R = Exp(r) R^, t = t^ + x, s = s^ exp(l). It is that of the positions' noise as measured from
  /// the residuals, their correlation along the flight included. Directions that are not observed
  /// have very large variances.
  Matrix7d covariance = Matrix7d::Zero();
  double sigma_scale = 0.0;                ///< relative: standard deviation of log(scale)
  double rms = 0.0;                        ///< metres: of the inliers' distances
  std::vector<std::size_t> inliers;        ///< rows of the camera file, ascending
  std::optional<GeodeticPosition> origin;  ///< null where the positions are metric
  double sigma_horizontal = 0.0, sigma_vertical = 0.0;  ///< metres, of one position and axis
  /// Variance of the scale over what independent errors of the same size would give; at least 1.
  double correlation_inflation = 1.0;
  std::vector<CameraFix> fixes;  ///< all cameras that have both, by row
  double time_offset = 0.0;      ///< seconds: GPS time less camera time; 0 unless the data show it
};

/// Georeferences by GPS or by metric positions of the cameras. Cameras and fixes meet by the name
/// of the image (with or without folders, in any case, in the end without the ending), or by time
/// with linear interpolation: `times` then gives the time of each camera (row k of camera k, or by
/// name where the cameras have names). Needs three cameras off a straight line, spread wider than
/// the noise: else `degenerate`, with the numbers in `reason`.
///
/// Robust: three-point samples (least median), Cauchy-weighted Gauss-Newton with the vertical
/// noise measured apart, least squares over the inliers. Its covariance takes the noise as partly
/// white, partly a first-order Gauss-Markov process; share and time of the correlation and the
/// ratio of vertical to horizontal noise are averaged over by their restricted likelihood.
///
/// Throws UsageError (an unknown method, GPS by time, or by image for cameras
/// without names, and no `times`) and InputError (`times` of
/// another length than the cameras).
Georeference ComputeGeoreference(const CameraModel& model, const GpsTrack& track,
                                 const std::optional<ImageTimes>& times,
                                 const GeoreferenceOptions& options = {});

}  // namespace planegraph
