#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "planegraph/io/local_frame.h"

namespace planegraph {

/// One position of a receiver (or of a camera, where the file is metric).
struct GpsFix {
  double time = std::numeric_limits<double>::quiet_NaN();  ///< seconds; NaN where by image
  std::string image;                                       ///< empty where by time
  std::optional<GeodeticPosition> geodetic;                ///< absent where the file is metric
  Eigen::Vector3d metric = Eigen::Vector3d::Zero();        ///< metres, where the file is metric
};

/// The fixes of a file in its order.
struct GpsTrack {
  std::vector<GpsFix> fixes;
  bool metric = false;    ///< metric positions in place of geodetic ones
  bool by_image = false;  ///< fixes belong to images in place of times
  /// Rows, sentences or images passed over: without a position, or with a wrong checksum.
  std::size_t skipped = 0;
};

/// Reads positions, told apart by the content:
/// - CSV (or `;`, tabs, blanks) with a header. Columns by name, in any order, others are ignored:
///   `time` or `image`, and `lat`, `lon`, `alt` (degrees, metres) or `x`, `y`, `z` (metres). Some
///   aliases are known (latitude, lng, long, longitude, altitude, height, ele, file, filename,
///   timestamp, easting, northing ...). Rows with an empty position are passed over.
/// - NMEA 0183: $GGA of any talker for positions (height above the ellipsoid where the sentence has
///   the geoid's), $RMC and $ZDA for the date. Times are seconds since 1970 where the file has a
///   date, else since the first midnight; they run on over midnight. Wrong checksums are counted.
/// - a folder of images (.jpg, .jpeg) with GPS in their EXIF, altitude as given there.
/// Latitude, longitude and altitude are checked to be on earth. Throws InputError; also where no
/// position is left.
GpsTrack ReadGps(const std::string& path);

/// The time of each image; row k belongs to camera k.
struct ImageTimes {
  std::vector<double> times;  ///< seconds, of the camera's clock
  std::vector<std::string> files;
  std::string source;  ///< the file they were read from, for messages
};

/// Reads a CSV with the columns `time` and `file` (by name, others are ignored). Throws InputError.
ImageTimes ReadImageTimes(const std::string& path);

}  // namespace planegraph
