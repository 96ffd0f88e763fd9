#pragma once

#include <Eigen/Core>

namespace planegraph {

/// A position on the WGS84 ellipsoid.
struct GeodeticPosition {
  double latitude = 0.0, longitude = 0.0;  ///< degrees, north and east positive
  double altitude = 0.0;                   ///< metres above the ellipsoid, or as the file gives it
};

/// The local frame that touches the WGS84 ellipsoid's parallel surface at an origin: x east, y
/// north, z up, metres. Cartesian and exact (by way of earth-centred coordinates, Karney's
/// GeographicLib): no map projection, no scale factor.
class LocalFrame {
 public:
  /// Throws UsageError where the origin is not finite, its latitude not within 90 or its longitude
  /// not within 180 degrees.
  explicit LocalFrame(const GeodeticPosition& origin);

  const GeodeticPosition& origin() const { return origin_; }
  Eigen::Vector3d ToLocal(const GeodeticPosition& position) const;
  GeodeticPosition ToGeodetic(const Eigen::Vector3d& x_in_local) const;

 private:
  GeodeticPosition origin_;
};

/// Finite, with latitude within 90, longitude within 180 degrees and altitude within 100 km of the
/// ellipsoid.
bool IsOnEarth(const GeodeticPosition& position);

}  // namespace planegraph
