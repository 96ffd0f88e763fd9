#pragma once

#include <Eigen/Core>
#include <optional>

#include "planegraph/correspondence/map_hypotheses.h"
#include "planegraph/registration/refinement.h"

namespace planegraph {

struct MapRefinementOptions {
  double first_gate = 1.0;  ///< metres along the normal, of the first association
  double last_gate = 0.15;  ///< metres, of the last one: below the thickness of walls and roofs
  static constexpr double kNarrowing = 0.7;  ///< of the gate, from one step to the next
  int most_iterations = 25;
  double rest = 3e-4;  ///< metres, and a tenth of it in radians: steps below end the iteration
  std::size_t most_surfels = 1500;  ///< of all scans together
  double scale = 1.0;               ///< prior of the scale
  double sigma_scale = 0.02;        ///< of log(scale) about it; 0: the scale is held
  bool pose_only = false;           ///< no residuals and no covariance of the result
};

/// A pair of surfaces that lie on each other: its height over the map's plane, for the statistics.
struct MapResidual {
  Eigen::Vector3d place, normal;  ///< map's axes; the normal is the map surface's
  double height;                  ///< metres: of the scan's surface over the map's
  double variance;                ///< of the height by both noise models, m^2
  std::size_t scan;               ///< index in the group
  std::int32_t map_surfel;
};

/// A group of scans laid onto a map by their surfaces.
struct MapRefinement {
  Sim3 map_from_group;
  /// With the map's errors as they were measured: see MapErrors.
  Matrix7d covariance = Matrix7d::Zero();
  std::vector<MapResidual> residuals;  ///< of the last association
  double floor = 0.0;                  ///< metres: error of the map that noise does not explain
  int iterations = 0;
  bool converged = false;
};

/// How a map errs, by the residuals of scans that were laid onto it as a rigid body: neighbouring
/// surfaces of a photogrammetric map err together, so that a thousand of them are not a thousand
/// measurements.
struct MapErrors {
  double sigma = 0.05;                   ///< metres: of one surface's height (robust)
  double block_sigma = 0.02;             ///< metres: that is left of it in the mean over a block
  bool measured = false;                 ///< whether `sigma` is, and not the default
  static constexpr double kBlock = 6.0;  ///< metres: edge of a block
};

/// Measures the errors: robust scale of the heights, and of their means over blocks of surfaces
/// that face the same way. Few residuals leave the defaults.
MapErrors MeasureMapErrors(const std::vector<MapResidual>& residuals);

/// Key of the block that a surface is in: its place, and the axis that it faces most.
std::uint64_t MapBlock(const Eigen::Vector3d& place, const Eigen::Vector3d& normal);

/// Iterated association of surfels and Gauss-Newton on their heights over the map's surfaces, from
/// a wide gate to a narrow one, as RefinePose does for scans; the scale is a seventh unknown with
/// its prior. Pairs face the same way: the underside of a roof is never its top.
MapRefinement RefineInMap(const MapModel& map, const ScanGroup& group, const Sim3& map_from_group,
                          const MapRefinementOptions& options = {});

}  // namespace planegraph
