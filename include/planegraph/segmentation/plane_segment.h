#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <string>
#include <vector>

#include "planegraph/geometry/moments.h"
#include "planegraph/geometry/plane.h"
#include "planegraph/segmentation/noise_model.h"
#include "planegraph/segmentation/range_image.h"

namespace planegraph {

/// Where a cloud comes from: it decides on noise floors and on how normals are turned.
enum class CloudKind { kLaser, kVision };

/// How the sign of a normal was found: it points to the side that the sensor saw, or nobody knows.
enum class Orientation { kSensor, kUnknown };

/// A small planar piece of a surface: the points within one cell of the segmentation's octree.
/// Patches keep a segment's locality (which part of a wall was seen) when the points are gone.
struct Patch {
  Moments moments;         ///< in the cloud's frame, metres
  Eigen::Vector3d normal;  ///< unit normal, turned like the segment's
  double size = 0.0;       ///< edge length of the cell, metres
  double sigma = 0.0;      ///< noise of one point along the normal by the sensor's model, metres
  int segment = -1;        ///< index into PlaneSet::planes, -1: part of none
  Orientation orientation = Orientation::kSensor;
};

/// Cells of a grid in the segment's plane that hold points: which part of the plane was seen. The
/// cell (i, j) covers origin + (i..i+1) * cell_size * u + (j..j+1) * cell_size * v.
struct SupportMask {
  Eigen::Vector3d origin = Eigen::Vector3d::Zero();
  Eigen::Vector3d u = Eigen::Vector3d::UnitX(), v = Eigen::Vector3d::UnitY();
  double cell_size = 0.0;                           ///< metres
  int min_i = 0, min_j = 0, width = 0, height = 0;  ///< the bitmap's place and size, cells
  std::vector<std::uint8_t> cells;                  ///< width * height, row j by row j; 1: occupied

  bool Occupied(int i, int j) const {
    const int x = i - min_i, y = j - min_j;
    return x >= 0 && y >= 0 && x < width && y < height && cells[std::size_t(y) * width + x] != 0;
  }
};

/// A planar segment of a cloud, in the cloud's frame. Everything after segmentation works on these:
/// the points themselves are not kept.
struct PlaneSegment {
  int id = 0;
  Plane plane;      ///< least-squares plane of the points; laser: towards the sensor
  Moments moments;  ///< of all its points
  /// Eigenvalues (increasing) and axes of moments.scatter; axes.vectors.col(0) = +-normal.
  PrincipalAxes axes;
  double rms = 0.0;        ///< root mean square distance of the points to the plane, metres
  double area = 0.0;       ///< square metres
  double thickness = 0.0;  ///< expected noise of a single point along the normal, metres
  /// Covariance of (tilt about axes 1 and 2 in radians, offset at the centroid in metres), with
  /// N_eff and the systematic floors: rows and columns in the order (delta along axis 1, delta
  /// along axis 2, offset), where normal -> normal + delta_1 axis_1 + delta_2 axis_2.
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
  Orientation orientation = Orientation::kSensor;
  CloudKind source = CloudKind::kLaser;
  SupportMask mask;
  std::vector<Eigen::Vector3d> hull;  ///< convex outline in the plane, in order, cloud frame

  const Eigen::Vector3d& centroid() const { return moments.mean; }
};

/// The planes of one cloud and what later steps need to know of the cloud itself.
struct PlaneSet {
  CloudKind kind = CloudKind::kLaser;
  std::vector<PlaneSegment> planes;
  /// All planar cells, those of segments and those too small for one.
  std::vector<Patch> patches;
  Eigen::Vector3d viewpoint = Eigen::Vector3d::Zero();  ///< sensor position, cloud frame
  Eigen::Vector3d offset = Eigen::Vector3d::Zero();  ///< taken off the cloud's coordinates before
  std::size_t point_count = 0;                       ///< of the cloud after the filters
  RangeImage range_image;  ///< free space as the laser saw it; empty for vision clouds
  NoiseModel noise;        ///< of a point along the normal, as estimated or given
};

}  // namespace planegraph
