#pragma once

// Rooms of rectangles with exact truth, as plane sets: for tests that need no points.
#include <cmath>
#include <random>
#include <vector>

#include "planegraph/geometry/rotation.h"
#include "planegraph/segmentation/plane_segment.h"

namespace planegraph {

struct Rectangle {
  Eigen::Vector3d center, u, v;  ///< u x v is the normal
  double half_u, half_v;         ///< metres
};

/// A hall with walls of different sizes, a ground, pillars and boxes that no symmetry maps onto
/// itself. World frame, metres.
inline std::vector<Rectangle> Hall() {
  const Eigen::Vector3d x(1, 0, 0), y(0, 1, 0), z(0, 0, 1);
  return {{{0, 0, 0}, x, y, 10, 6},   // ground
          {{-10, 0, 2}, y, z, 6, 2},  // walls
          {{10, -1.5, 2.2}, z, y, 2.2, 4.5},
          {{0, -6, 2.5}, z, x, 2.5, 9},
          {{-1, 6, 2}, x, z, 7, 2},
          {{4, 1, 1.1}, y, z, 1.5, 1.1},  // a box
          {{3, 2.5, 0.8}, x, z, 1, 0.8},
          {{3, -0.5, 0.9}, z, x, 0.9, 1.1},
          {{-4, -2, 1.4}, z, y, 1.4, 1.2},  // a screen
          {{6, 3, 1.2}, (x + y).normalized(), z, 1.3, 1.2},
          {{-6, 3, 1.5}, (x - 2 * y).normalized(), z, 1.6, 1.5}};
}

/// A corridor along x without ends: two directions only. One wall is low, so that the turn by 180
/// degrees does not fit.
inline std::vector<Rectangle> Corridor() {
  const Eigen::Vector3d x(1, 0, 0), y(0, 1, 0), z(0, 0, 1);
  return {
      {{0, 0, 0}, x, y, 10, 1.2}, {{0, -1.2, 1.5}, z, x, 1.5, 10}, {{0, 1.2, 0.5}, x, z, 10, 0.5}};
}

inline PlaneSegment MakeSegment(const Rectangle& r, const Rigid3& scan_from_world, int id) {
  PlaneSegment s;
  s.id = id;
  const Eigen::Vector3d c = scan_from_world * r.center;
  const Eigen::Vector3d u = scan_from_world.rotation * r.u, v = scan_from_world.rotation * r.v;
  const Eigen::Vector3d n = u.cross(v);
  s.plane = {n, n.dot(c)};
  constexpr double kDensity = 400.0;  // points per m^2
  s.area = 4 * r.half_u * r.half_v;
  s.moments.count = kDensity * s.area;
  s.moments.mean = c;
  s.moments.scatter = s.moments.count / 3.0 *
                      (r.half_u * r.half_u * u * u.transpose() +
                       r.half_v * r.half_v * v * v.transpose() + 1e-4 * n * n.transpose());
  s.axes = ComputePrincipalAxes(s.moments.scatter);
  s.covariance = Eigen::Vector3d(1e-6, 1e-6, 2.5e-5).asDiagonal();
  s.mask.origin = c, s.mask.u = u, s.mask.v = v, s.mask.cell_size = 0.25;
  const int wide = static_cast<int>(std::lround(4 * r.half_u)) * 2;
  const int high = static_cast<int>(std::lround(4 * r.half_v)) * 2;
  s.mask.min_i = -wide / 2 - 2, s.mask.min_j = -high / 2 - 2;
  s.mask.width = wide + 4, s.mask.height = high + 4;
  s.mask.cells.assign(std::size_t(s.mask.width) * s.mask.height, 0);
  for (int j = 2; j < high + 2; ++j) {
    for (int i = 2; i < wide + 2; ++i) s.mask.cells[std::size_t(j) * s.mask.width + i] = 1;
  }
  return s;
}

/// The planes of a scene as a scan at `world_from_scan` measures them, with noise of that size on
/// normals (radians) and offsets (metres) and, with `shuffle`, in an order of its own.
inline PlaneSet Measure(const std::vector<Rectangle>& scene, const Rigid3& world_from_scan,
                        double tilt, double offset, std::uint64_t seed) {
  std::mt19937_64 rng(seed);
  std::normal_distribution<double> normal;
  PlaneSet set;
  for (const Rectangle& r : scene) {
    Rectangle seen = r;
    const double a = tilt * normal(rng), b = tilt * normal(rng), h = offset * normal(rng);
    const Eigen::Quaterniond turn = ExpSO3(a * r.u + b * r.v);
    seen.u = turn * r.u, seen.v = turn * r.v;
    seen.center += h * r.u.cross(r.v) + 0.3 * normal(rng) * r.u;
    set.planes.push_back(
        MakeSegment(seen, world_from_scan.Inverse(), static_cast<int>(set.planes.size())));
  }
  return set;
}

}  // namespace planegraph
