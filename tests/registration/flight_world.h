#pragma once

#include <cmath>
#include <random>

#include "planegraph/geometry/rotation.h"
#include "planegraph/registration/georeference.h"

namespace planegraph {

/// A flight with exact truth: where the camera is at a time, the model that photogrammetry would
/// give, and positions by a receiver.
struct FlightWorld {
  Sim3 world_from_map{8.5, ExpSO3({0.4, -2.0, 0.7}), {30.0, -12.0, 55.0}};
  GeodeticPosition origin{51.488, 7.493, 115.0};
  int cameras = 120;
  double spacing = 2.0;  ///< seconds between images

  /// Metres; about 3 m/s, with height.
  static Eigen::Vector3d At(double t) {
    return {30.0 * std::sin(0.07 * t), 25.0 * std::sin(0.11 * t + 0.5),
            40.0 + 6.0 * std::sin(0.05 * t)};
  }
  CameraModel Model() const {
    CameraModel model;
    for (int k = 0; k < cameras; ++k) {
      Camera camera;
      camera.valid = true;
      camera.image = "img_" + std::to_string(1000 + k) + ".jpg";
      camera.camera_from_model.rotation = ExpSO3({0.1 * k, 0.3, -0.2});
      const Eigen::Vector3d centre = world_from_map.Inverse() * At(spacing * k);
      camera.camera_from_model.translation = -(camera.camera_from_model.rotation * centre);
      model.cameras.push_back(camera);
    }
    return model;
  }
  ImageTimes Times() const {
    ImageTimes times;
    for (int k = 0; k < cameras; ++k) {
      times.times.push_back(spacing * k);
      times.files.push_back("img_" + std::to_string(1000 + k) + ".jpg");
    }
    return times;
  }
  /// A fix at each camera's time, plus `noise[k]`.
  GpsTrack Track(const std::vector<Eigen::Vector3d>& noise) const {
    GpsTrack track;
    const LocalFrame frame(origin);
    for (int k = 0; k < cameras; ++k) {
      GpsFix fix;
      fix.time = spacing * k;
      fix.geodetic = frame.ToGeodetic(At(fix.time) + noise[static_cast<std::size_t>(k)]);
      track.fixes.push_back(fix);
    }
    return track;
  }
  /// Metric positions by the images' names.
  GpsTrack MetricTrack(const std::vector<Eigen::Vector3d>& noise) const {
    GpsTrack track;
    track.metric = track.by_image = true;
    for (int k = 0; k < cameras; ++k) {
      GpsFix fix;
      fix.image = "img_" + std::to_string(1000 + k) + ".jpg";
      fix.metric = At(spacing * k) + noise[static_cast<std::size_t>(k)];
      track.fixes.push_back(fix);
    }
    return track;
  }
  std::vector<Eigen::Vector3d> NoNoise() const {
    return std::vector<Eigen::Vector3d>(static_cast<std::size_t>(cameras), Eigen::Vector3d::Zero());
  }
  /// White noise plus a Gauss-Markov process of `time` seconds, each with its standard deviations.
  std::vector<Eigen::Vector3d> Noise(std::mt19937_64* rng, const Eigen::Vector3d& white,
                                     const Eigen::Vector3d& correlated = Eigen::Vector3d::Zero(),
                                     double time = 40.0) const {
    std::normal_distribution<double> normal;
    const auto draw = [&] { return normal(*rng); };
    const double decay = std::exp(-spacing / time);
    Eigen::Vector3d state = Eigen::Vector3d::NullaryExpr(draw);
    std::vector<Eigen::Vector3d> noise;
    for (int k = 0; k < cameras; ++k) {
      noise.push_back(correlated.cwiseProduct(state) +
                      white.cwiseProduct(Eigen::Vector3d::NullaryExpr(draw)));
      state = decay * state + std::sqrt(1 - decay * decay) * Eigen::Vector3d::NullaryExpr(draw);
    }
    return noise;
  }
  GeoreferenceOptions Options() const {
    GeoreferenceOptions options;
    options.origin = origin;
    options.max_time_offset = 0.0;
    return options;
  }
  /// The error in the order of the covariance.
  Eigen::Matrix<double, 7, 1> ErrorOf(const Sim3& estimate) const {
    Eigen::Matrix<double, 7, 1> error;
    error << estimate.translation - world_from_map.translation,
        LogSO3(estimate.rotation * world_from_map.rotation.conjugate()),
        std::log(estimate.scale / world_from_map.scale);
    return error;
  }
};

inline Georeference Locate(const FlightWorld& world, const GpsTrack& track,
                           const GeoreferenceOptions& options) {
  return ComputeGeoreference(world.Model(), track, world.Times(), options);
}

}  // namespace planegraph
