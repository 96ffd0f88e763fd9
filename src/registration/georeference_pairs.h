#pragma once

#include <optional>
#include <vector>

#include "planegraph/registration/georeference.h"
#include "registration/fix_track.h"

namespace planegraph {

/// A camera's centre and where GPS puts it.
struct PositionPair {
  std::size_t camera = 0;
  Eigen::Vector3d in_map = Eigen::Vector3d::Zero();
  Eigen::Vector3d in_world = Eigen::Vector3d::Zero();
  Eigen::Vector3d velocity = Eigen::Vector3d::Zero();  ///< in the world, m/s; zero by image
  double time = 0.0;  ///< seconds along the flight, or the place in the order of names
};

/// Brings cameras and fixes together. Pairs come in the order of the flight (time, else the
/// images' names), so that nothing depends on the order of the files.
class CameraPairing {
 public:
  /// Throws UsageError, InputError as ComputeGeoreference does.
  CameraPairing(const CameraModel& model, const GpsTrack& track,
                const std::optional<ImageTimes>& times, const GeoreferenceOptions& options);

  const std::optional<GeodeticPosition>& origin() const { return origin_; }
  bool by_time() const { return !track_.by_image; }
  /// Times of the pairs are seconds (else places in an order).
  bool has_times() const { return track_in_world_.has_times(); }
  /// Whole days between the clocks, where the times would not overlap otherwise, seconds.
  double day_shift() const { return day_shift_; }
  std::size_t valid_cameras() const;

  /// Interpolated at the camera's time plus `time_offset`, or by image.
  std::vector<PositionPair> Pairs(double time_offset) const;
  /// The nearest fix for every camera, as the paper does.
  std::vector<PositionPair> NearestPairs() const;

 private:
  void ReadTimes(const std::optional<ImageTimes>& times);
  void AddFixes();
  void FindDayShift();
  PositionPair PairOf(std::size_t camera) const;
  std::vector<PositionPair> PairsByImage() const;
  bool Interpolate(double time, PositionPair* pair) const;

  const CameraModel& model_;
  const GpsTrack& track_;
  GeoreferenceOptions options_;
  std::optional<GeodeticPosition> origin_;
  FixTrack track_in_world_;
  std::vector<double> camera_times_;  ///< one per camera, by time alone
  std::vector<std::string> camera_names_;
  double day_shift_ = 0.0;
};

}  // namespace planegraph
