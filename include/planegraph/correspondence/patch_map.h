#pragma once

#include <cstdint>
#include <vector>

#include "planegraph/correspondence/surface_filter.h"
#include "planegraph/segmentation/plane_segment.h"

namespace planegraph {

/// A patch as registration sees it: its plane with what it says of its own uncertainty.
struct Surfel {
  Eigen::Vector3d mean, normal;
  Eigen::Vector3d axis1, axis2;  ///< in-plane principal axes
  double variance1,
      variance2;           ///< of the tilt about them: variance of a height at a distance of 1 m
  double offset_variance;  ///< of the height at the mean, m^2
  double size;             ///< edge length of its cell, metres
  double area;             ///< size^2
  std::int32_t segment;

  /// Variance of the surface's height at a point near the patch, m^2.
  double HeightVariance(const Eigen::Vector3d& point) const;
};

/// Points of a surface nearer than this do not count as independent, metres: multi-view stereo
/// matches and smooths over windows.
double CorrelationLength(CloudKind kind);

/// The surfels of a plane set; points within `correlation_length` of each other do not count as
/// independent. A patch that may face either way is two surfels, one for each.
std::vector<Surfel> MakeSurfels(const PlaneSet& planes, double correlation_length);
inline std::vector<Surfel> MakeSurfels(const PlaneSet& planes) {
  return MakeSurfels(planes, CorrelationLength(planes.kind));
}

/// A hash grid over surfels that answers which surface lies at a point.
class PatchMap {
 public:
  explicit PatchMap(std::vector<Surfel> surfels);

  const std::vector<Surfel>& surfels() const { return surfels_; }

  /// The surfel whose plane is nearest to `point` (target frame), among those that face like
  /// `normal` (cosine at least `least_cosine`), lie within `gate` metres along their normal, and
  /// whose cell (half as much again) reaches to the point's foot. -1 where there is none.
  int Find(const Eigen::Vector3d& point, const Eigen::Vector3d& normal, double gate,
           double least_cosine) const;

  /// Says where `Find` has no answer, for gates and cosines up to the filter's.
  const SurfaceFilter& filter() const { return filter_; }

 private:
  struct Query;
  void BestInCell(std::uint64_t hash, Query* query) const;

  // The tag stands for the cell and the sides that the surfel faces: one of another cell that slips
  // through is still tested.
  struct Item {
    std::uint32_t tag, surfel;
  };

  std::vector<Surfel> surfels_;
  std::vector<SurfaceFace> faces_;  // by surfel: what a query reads of it
  SurfaceFilter filter_;
  std::vector<std::uint64_t> filled_;  // a bit for each hash slot: most queries meet empty space
  std::vector<std::uint32_t> starts_;  // by hash slot
  std::vector<Item> items_;
  std::uint64_t mask_ = 0;
};

}  // namespace planegraph
