#include "planegraph/correspondence/open_sky.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

namespace planegraph {
namespace {

constexpr double kLeastColumn = 0.5;      // metres: what photogrammetry still resolves at edges
constexpr double kMostColumns = 1 << 24;  // larger maps get wider columns
constexpr double kMargin = 0.4;           // metres of height, for the blur of edges
constexpr double kAside = 0.5;            // metres before and behind a wall
constexpr double kFacesUp = 0.5, kFlat = 0.7;
// Of a map whose surfaces face where they were seen from, the sum of the normals keeps at least
// this share of the area. Where both sides of each are possible nothing is left of it.
constexpr double kLeastUp = 0.2;

Eigen::Matrix3d UpToZ(const std::vector<Surfel>& surfels) {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  double area = 0.0;
  for (const Surfel& s : surfels) {
    sum += s.area * s.normal;
    area += s.area;
  }
  if (!(sum.norm() > kLeastUp * area)) return Eigen::Matrix3d::Zero();
  return Eigen::Quaterniond::FromTwoVectors(sum, Eigen::Vector3d::UnitZ()).toRotationMatrix();
}

}  // namespace

OpenSky::OpenSky(const std::vector<Surfel>& surfels) : columns_from_map_(UpToZ(surfels)) {
  if (columns_from_map_.isZero()) return;
  Eigen::Vector2d low = Eigen::Vector2d::Constant(INFINITY), high = -low;
  for (const Surfel& s : surfels) {
    const Eigen::Vector2d at = (columns_from_map_ * s.mean).head<2>();
    low = low.cwiseMin(at.array().matrix() - Eigen::Vector2d::Constant(s.size));
    high = high.cwiseMax(at + Eigen::Vector2d::Constant(s.size));
  }
  cell_ = std::max(kLeastColumn, std::sqrt((high - low).prod() / kMostColumns));
  low_ = low;
  width_ = static_cast<long>((high - low).x() / cell_) + 1;
  height_ = static_cast<long>((high - low).y() / cell_) + 1;
  highest_.assign(static_cast<std::size_t>(width_ * height_), -INFINITY);
  for (const Surfel& s : surfels) {
    if (columns_from_map_.row(2).dot(s.normal) >= kFacesUp) Mark(s);
  }
}

long OpenSky::Column(const Eigen::Vector3d& point) const {
  const Eigen::Vector2d at = (point.head<2>() - low_) / cell_;
  if (!(at.minCoeff() >= 0.0)) return -1;
  if (at.x() >= static_cast<double>(width_) || at.y() >= static_cast<double>(height_)) return -1;
  return static_cast<long>(at.y()) * width_ + static_cast<long>(at.x());
}

void OpenSky::Mark(const Surfel& s) {
  const int steps = std::max(1, static_cast<int>(std::ceil(s.size / cell_)));
  const Eigen::Vector3d across = s.normal.cross(s.axis1);
  for (int a = -steps; a <= steps; ++a) {
    for (int b = -steps; b <= steps; ++b) {
      const double u = 0.5 * s.size * a / steps, v = 0.5 * s.size * b / steps;
      const Eigen::Vector3d point = columns_from_map_ * (s.mean + u * s.axis1 + v * across);
      const long column = Column(point);
      if (column < 0) continue;
      auto& highest = highest_[static_cast<std::size_t>(column)];
      highest = std::max(highest, static_cast<float>(point.z()));
    }
  }
}

bool OpenSky::Free(const Eigen::Vector3d& point) const {
  if (!known()) return false;
  const Eigen::Vector3d turned = columns_from_map_ * point;
  const long column = Column(turned);
  if (column < 0) return false;
  const float highest = highest_[static_cast<std::size_t>(column)];
  return std::isfinite(highest) && highest < turned.z() - kMargin;
}

bool OpenSky::Open(const Eigen::Vector3d& point, const Eigen::Vector3d& normal) const {
  if (!known()) return false;
  if (std::abs(columns_from_map_.row(2).dot(normal)) > kFlat) return Free(point);
  // Behind the wall of a house is its roof: only what stands free on both sides is in the open.
  return Free(point + kAside * normal) && Free(point - kAside * normal);
}

}  // namespace planegraph
