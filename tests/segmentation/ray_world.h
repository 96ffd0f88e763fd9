#pragma once

#include <cmath>
#include <cstdint>
#include <numbers>
#include <random>
#include <vector>

#include "planegraph/cloud/cloud.h"
#include "planegraph/geometry/plane.h"
#include "planegraph/geometry/rigid3.h"
#include "planegraph/geometry/rotation.h"

namespace planegraph {

/// A rectangle that is seen from the side its normal u x v points to.
struct Face {
  Eigen::Vector3d centre, u, v;  ///< u, v: unit, orthogonal
  double half_u, half_v;         ///< metres

  Eigen::Vector3d normal() const { return u.cross(v); }
  Plane plane() const { return {normal(), normal().dot(centre)}; }
};

/// A tiny world of rectangles and a laser in it: enough to test with exact truth.
struct RayWorld {
  std::vector<Face> faces;

  void AddFace(const Eigen::Vector3d& centre, const Eigen::Vector3d& normal, double half_u,
               double half_v) {
    const Eigen::Vector3d up =
        std::abs(normal.z()) > 0.9 ? Eigen::Vector3d::UnitX() : Eigen::Vector3d::UnitZ();
    const Eigen::Vector3d u = up.cross(normal).normalized();
    faces.push_back({centre, u, normal.cross(u), half_u, half_v});
  }

  /// The inside (side = -1) or outside (side = 1) of an upright box that stands on z = base.
  void AddBox(const Eigen::Vector3d& foot, const Eigen::Vector3d& size, double yaw, double side) {
    const Eigen::Vector3d x(std::cos(yaw), std::sin(yaw), 0), y(-x.y(), x.x(), 0);
    const Eigen::Vector3d z = Eigen::Vector3d::UnitZ(), centre = foot + 0.5 * size.z() * z;
    for (const double s : {-1.0, 1.0}) {
      AddFace(centre + 0.5 * s * size.x() * x, side * s * x, 0.5 * size.y(), 0.5 * size.z());
      AddFace(centre + 0.5 * s * size.y() * y, side * s * y, 0.5 * size.x(), 0.5 * size.z());
      faces.push_back(
          {centre + 0.5 * s * size.z() * z, x, side * s * y, 0.5 * size.x(), 0.5 * size.y()});
    }
  }
};

/// An empty room, its floor's centre at the origin.
inline RayWorld EmptyRoom(const Eigen::Vector3d& size) {
  RayWorld world;
  world.AddBox(Eigen::Vector3d::Zero(), size, 0.0, -1.0);
  return world;
}

/// A room of 11 x 8 x 3.2 m with six boxes at random, all clear of its middle.
inline RayWorld FurnishedRoom(std::uint64_t seed) {
  RayWorld world = EmptyRoom({11.0, 8.0, 3.2});
  std::mt19937_64 engine(seed);
  std::uniform_real_distribution<double> uniform(0.0, 1.0);
  for (int k = 0; k < 6; ++k) {
    const double angle = (k + 0.6 * uniform(engine)) * std::numbers::pi / 3.0;
    const Eigen::Vector3d foot(4.2 * std::cos(angle), 3.0 * std::sin(angle), 0.0);
    const Eigen::Vector3d size(0.6 + 0.9 * uniform(engine), 0.6 + 0.9 * uniform(engine),
                               0.5 + 1.8 * uniform(engine));
    world.AddBox(foot, size, 2.0 * uniform(engine), 1.0);
  }
  return world;
}

struct LaserNoise {
  double constant = 0.005, per_metre = 0.0;  ///< standard deviation along the beam, metres
};

struct RayScan {
  Cloud cloud;              ///< the scanner's frame
  std::vector<int> labels;  ///< the face that was hit
};

/// Looks in `rays` evenly spread directions (Fibonacci's spiral), all the way round.
inline RayScan ScanWorld(const RayWorld& world, const Rigid3& world_from_scan, int rays,
                         const LaserNoise& noise, std::uint64_t seed, double max_range = 40.0) {
  RayScan scan;
  std::mt19937_64 engine(seed);
  std::normal_distribution<double> normal;
  const double golden = std::numbers::pi * (3.0 - std::sqrt(5.0));
  for (int i = 0; i < rays; ++i) {
    const double z = 1.0 - 2.0 * (i + 0.5) / rays, r = std::sqrt(1.0 - z * z);
    const Eigen::Vector3d beam(r * std::cos(golden * i), r * std::sin(golden * i), z);
    const Eigen::Vector3d direction = world_from_scan.rotation * beam;
    double range = max_range;
    int hit = -1;
    for (std::size_t f = 0; f < world.faces.size(); ++f) {
      const Face& face = world.faces[f];
      const double towards = face.normal().dot(direction);
      if (towards > -1e-9) continue;
      const double distance = -face.plane().SignedDistance(world_from_scan.translation) / towards;
      if (!(distance > 0.0 && distance < range)) continue;
      const Eigen::Vector3d d = world_from_scan.translation + distance * direction - face.centre;
      if (std::abs(face.u.dot(d)) > face.half_u || std::abs(face.v.dot(d)) > face.half_v) continue;
      range = distance, hit = static_cast<int>(f);
    }
    if (hit < 0) continue;
    const double measured = range + normal(engine) * (noise.constant + noise.per_metre * range);
    scan.cloud.points.emplace_back((measured * beam).cast<float>());
    scan.labels.push_back(hit);
  }
  return scan;
}

inline Rigid3 MakePose(double x, double y, double z, double yaw, double roll = 0.0,
                       double pitch = 0.0) {
  return {(ExpSO3({0, 0, yaw}) * ExpSO3({roll, pitch, 0})).normalized(), {x, y, z}};
}

}  // namespace planegraph
