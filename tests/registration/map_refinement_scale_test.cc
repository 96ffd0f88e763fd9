// A scale that is held stays where the start has it: maps are registered to with a scale that other
// scans have corrected.
#include <gtest/gtest.h>

#include "planegraph/geometry/moments.h"
#include "planegraph/registration/map_refinement.h"
#include "registration/plane_rooms.h"

namespace planegraph {
namespace {

// The points of a square cell of a surface, as they lie.
Patch MakePatch(const Eigen::Vector3d& center, const Rectangle& r, double size, int segment) {
  constexpr double kCount = 50.0, kSigma = 0.005;
  const Eigen::Vector3d normal = r.u.cross(r.v);
  Patch patch;
  patch.normal = normal;
  patch.size = size;
  patch.sigma = kSigma;
  patch.segment = segment;
  patch.moments.count = kCount;
  patch.moments.mean = center;
  patch.moments.scatter =
      kCount * (size * size / 12.0 * (r.u * r.u.transpose() + r.v * r.v.transpose()) +
                kSigma * kSigma * normal * normal.transpose());
  return patch;
}

// The hall in a frame that is `scale` times as large, cut into patches.
PlaneSet HallInPatches(double scale) {
  constexpr double kCell = 0.8;  // metres
  PlaneSet set;
  for (Rectangle r : Hall()) {
    r.center *= scale, r.half_u *= scale, r.half_v *= scale;
    const int id = static_cast<int>(set.planes.size());
    set.planes.push_back(MakeSegment(r, Rigid3(), id));
    const double cell = scale * kCell;
    for (double a = -r.half_u + cell / 2; a < r.half_u; a += cell) {
      for (double b = -r.half_v + cell / 2; b < r.half_v; b += cell) {
        set.patches.push_back(MakePatch(r.center + a * r.u + b * r.v, r, cell, id));
      }
    }
  }
  return set;
}

TEST(MapRefinement, ScaleThatIsHeldStaysWhereTheStartHasIt) {
  const double scale = 1.02;  // of the map's unit: what GPS got wrong and the placing corrected
  const PlaneSet map_planes = HallInPatches(scale), scan_planes = HallInPatches(1.0);
  const MapModel map(map_planes);
  const ScanModel scan(scan_planes);
  MapRefinementOptions options;
  options.first_gate = 0.3;
  options.sigma_scale = 0.0;
  const Sim3 truth(scale, Eigen::Quaterniond::Identity(), Eigen::Vector3d::Zero());
  const MapRefinement found = RefineInMap(map, ScanGroup(scan), truth, options);
  EXPECT_NEAR(found.map_from_group.scale, scale, 1e-9);
  EXPECT_LT(found.map_from_group.translation.norm(), 1e-3);
}

}  // namespace
}  // namespace planegraph
