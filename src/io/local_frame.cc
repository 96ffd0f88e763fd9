#include "planegraph/io/local_frame.h"

#include <GeographicLib/LocalCartesian.hpp>
#include <cmath>

#include "planegraph/base/error.h"

namespace planegraph {
namespace {

GeographicLib::LocalCartesian At(const GeodeticPosition& origin) {
  return {origin.latitude, origin.longitude, origin.altitude};
}

}  // namespace

bool IsOnEarth(const GeodeticPosition& position) {
  constexpr double kHighest = 1e5;
  return std::abs(position.latitude) <= 90.0 && std::abs(position.longitude) <= 180.0 &&
         std::abs(position.altitude) <= kHighest;
}

LocalFrame::LocalFrame(const GeodeticPosition& origin) : origin_(origin) {
  if (!IsOnEarth(origin)) throw UsageError("the origin of the local frame is no place on earth");
}

Eigen::Vector3d LocalFrame::ToLocal(const GeodeticPosition& position) const {
  Eigen::Vector3d local;
  At(origin_).Forward(position.latitude, position.longitude, position.altitude, local.x(),
                      local.y(), local.z());
  return local;
}

GeodeticPosition LocalFrame::ToGeodetic(const Eigen::Vector3d& x_in_local) const {
  GeodeticPosition position;
  At(origin_).Reverse(x_in_local.x(), x_in_local.y(), x_in_local.z(), position.latitude,
                      position.longitude, position.altitude);
  return position;
}

}  // namespace planegraph
