#pragma once

#include <vector>

#include "planegraph/correspondence/xiao_matcher.h"
#include "planegraph/registration/closed_form.h"
#include "planegraph/segmentation/plane_segment.h"
#include "planegraph/solve/metascan.h"

namespace planegraph {

/// A scan's segment in the world, as one pose puts it there.
struct WorldSegment {
  const PlaneSegment* segment;
  Rigid3 world_from_scan;
  Eigen::Vector3d normal, centroid;
  PlaneBox box;
};

/// The segments of a scan that are large enough, in the world.
std::vector<WorldSegment> PlaceSegments(const PlaneSet& scan, const Rigid3& world_from_scan,
                                        double min_area);

/// When two surfaces in the world are one.
struct CoincidenceGate {
  CoincidenceGate(double max_angle_deg, double max_offset, double overlap_tolerance);
  double least_cosine, max_offset, tolerance;

  bool Admits(const Eigen::Vector3d& normal, const Eigen::Vector3d& centroid, const PlaneBox& box,
              const WorldSegment& other) const;
};

/// Segments of several scans that are one surface.
struct MetaSegment {
  Moments moments;
  Eigen::Vector3d normal;
  FittedPlane plane;
  PlaneBox box;
  std::vector<const WorldSegment*> members;

  /// Area of the union of the members' masks, m^2: what one scan does not see another may.
  /// Computed when it is first asked for.
  double Area();

 private:
  double area_ = -1.0;
};

/// The segments of the neighbours with the coinciding ones merged, largest first.
std::vector<MetaSegment> MergeSegments(
    const std::vector<const std::vector<WorldSegment>*>& neighbours, const CoincidenceGate& gate);

}  // namespace planegraph
