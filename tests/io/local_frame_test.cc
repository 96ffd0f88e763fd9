#include "planegraph/io/local_frame.h"

#include <gtest/gtest.h>

#include <cmath>

#include "planegraph/base/error.h"

namespace planegraph {
namespace {

constexpr double kEquator = 6378137.0, kPole = 6356752.3142451794;  // half axes of WGS84, metres

TEST(LocalFrame, PlacesOnTheAxesOfTheEllipsoid) {
  const LocalFrame frame({0.0, 0.0, 0.0});
  const Eigen::Vector3d east = frame.ToLocal({0.0, 90.0, 0.0});
  EXPECT_LT((east - Eigen::Vector3d(kEquator, 0, -kEquator)).norm(), 1e-6);
  const Eigen::Vector3d north = frame.ToLocal({90.0, 0.0, 0.0});
  EXPECT_LT((north - Eigen::Vector3d(0, kPole, -kEquator)).norm(), 1e-6);
  EXPECT_LT((frame.ToLocal({0.0, 0.0, 7.0}) - Eigen::Vector3d(0, 0, 7)).norm(), 1e-9);
}

TEST(LocalFrame, SmallStepsFollowTheRadiiOfCurvature) {
  const GeodeticPosition origin{51.488, 7.493, 115.0};
  const double rad = std::acos(-1.0) / 180.0, sine = std::sin(origin.latitude * rad);
  const double e2 = 1.0 - kPole * kPole / (kEquator * kEquator);
  const double root = std::sqrt(1.0 - e2 * sine * sine);
  const double meridian = kEquator * (1.0 - e2) / (root * root * root) + origin.altitude;
  const double parallel = (kEquator / root + origin.altitude) * std::cos(origin.latitude * rad);
  const LocalFrame frame(origin);
  const double step = 1e-5;
  const Eigen::Vector3d local =
      frame.ToLocal({origin.latitude + step, origin.longitude + step, origin.altitude + 2.0});
  EXPECT_NEAR(local.x(), parallel * step * rad, 1e-5);
  EXPECT_NEAR(local.y(), meridian * step * rad, 1e-5);
  EXPECT_NEAR(local.z(), 2.0, 1e-5);
}

TEST(LocalFrame, ThereAndBack) {
  const LocalFrame frame({-33.9, 18.4, 42.0});
  for (const Eigen::Vector3d& point :
       {Eigen::Vector3d(0, 0, 0), Eigen::Vector3d(1234.5, -987.6, 55.5)}) {
    EXPECT_LT((frame.ToLocal(frame.ToGeodetic(point)) - point).norm(), 1e-7);
  }
  EXPECT_EQ(frame.origin().altitude, 42.0);
}

TEST(LocalFrame, RefusesNoPlaces) {
  EXPECT_THROW(LocalFrame({91.0, 0.0, 0.0}), UsageError);
  EXPECT_THROW(LocalFrame({0.0, 181.0, 0.0}), UsageError);
  EXPECT_THROW(LocalFrame({0.0, 0.0, INFINITY}), UsageError);
  EXPECT_THROW(LocalFrame({NAN, 0.0, 0.0}), UsageError);
}

}  // namespace
}  // namespace planegraph
