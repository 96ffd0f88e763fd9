#pragma once

#include <vector>

#include "planegraph/segmentation/segmenter.h"
#include "segmentation/cell_octree.h"

namespace planegraph {

/// A planar cell of the octree: the coarsest one that passes the planarity test.
struct PlanarCell {
  int level;
  std::uint32_t index;  ///< in octree.Level(level)
  Eigen::Vector3d mean, normal;
  double count;
  double sigma;             ///< expected noise of one of its points along the normal, metres
  double tilt;              ///< standard deviation of its normal about the worse axis, radians
  Orientation orientation;  ///< how the sign of the normal was found
};

/// The cell at each level that a point lies in, as far as the split went.
struct CellSplit {
  std::vector<PlanarCell> planar;
  /// For each level and cell: the planar cell that it is or lies in, kSplit where it was divided
  /// further, kRough where it is a finest cell that is not planar.
  static constexpr std::int32_t kSplit = -1, kRough = -2;
  std::vector<std::vector<std::int32_t>> owner;
};

/// Where a surface lies as the sensor sees it. A photogrammetric cloud has no single sensor: its
/// noise does not depend on where a point lies, and range 0 and cosine 1 stand for that.
struct Sighting {
  double range = 0.0;   ///< metres
  double cosine = 1.0;  ///< of the incidence angle, in [0, 1]
  Sighting(const Cloud& cloud, CloudKind kind, const Eigen::Vector3d& point,
           const Eigen::Vector3d& normal);
};

/// Whether the points spread enough in both directions to define a plane: a single scan line lies
/// in the plane of its own scan, whatever it hit.
bool SpansPlane(const PrincipalAxes& axes, double count, double sigma);

/// Samples for EstimateNoise from cells of about four finest edges.
std::vector<NoiseSample> CollectNoiseSamples(const CellOctree& octree, const Cloud& cloud,
                                             CloudKind kind);

/// Whether the scatter of `count` points about their plane is what noise of `sigma` allows.
bool IsPlanar(double smallest_eigenvalue, double count, double sigma, double planarity);

CellSplit SplitIntoPlanarCells(const CellOctree& octree, const Cloud& cloud,
                               const NoiseModel& noise, const SegmentationOptions& options);

}  // namespace planegraph
