#pragma once

#include <optional>
#include <string>
#include <vector>

#include "planegraph/io/gps_io.h"

namespace planegraph {

/// The fixes of a receiver in the world, metres; ascending in time and one for each time where they
/// go by time, else in the file's order.
class FixTrack {
 public:
  struct Fix {
    double time = 0.0;
    Eigen::Vector3d in_world = Eigen::Vector3d::Zero();
    std::string image;
  };
  struct Moving {
    Eigen::Vector3d position = Eigen::Vector3d::Zero();
    Eigen::Vector3d velocity = Eigen::Vector3d::Zero();  ///< m/s
  };

  FixTrack() = default;
  /// `origin` of the local east-north-up frame; without meaning where the track is metric.
  FixTrack(const GpsTrack& track, const std::optional<GeodeticPosition>& origin);

  const std::vector<Fix>& fixes() const { return fixes_; }
  /// All fixes have a time.
  bool has_times() const { return has_times_; }

  /// Between two fixes that are at most `max_gap` seconds apart, or at the very time of one.
  std::optional<Moving> Interpolate(double time, double max_gap) const;
  /// The fix that is nearest in time; null where there is none.
  const Fix* Nearest(double time) const;
  /// Seconds to add to times between `first` and `last` whose clock differs from the fixes' by
  /// whole days (seconds of the day against seconds since 1970); 0 where they overlap as they are.
  double DayShift(double first, double last) const;

 private:
  std::vector<Fix> fixes_;
  bool has_times_ = true;
};

}  // namespace planegraph
