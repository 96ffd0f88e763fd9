#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "planegraph/evaluation/interval.h"
#include "planegraph/io/labelled_cloud.h"

namespace planegraph {

struct PlaneThicknessOptions {
  double cell = 0.8;         ///< metres: within it a surface counts as flat
  double gate = 0.15;        ///< metres: between the planes of two scans that are one surface
  double map_gate = 0.4;     ///< likewise of a scan's and a drone map's
  double cosine = 0.97;      ///< between the normals of two scans' planes that are one surface
  double map_cosine = 0.94;  ///< likewise of a scan's and a drone map's
  double least_points = 10;  ///< of a plane's piece in a cell
};

/// Root mean square distances to local planes, metres; all of it over points.
struct ThicknessSum {
  double squares = 0.0, points = 0.0;
  double Rms() const;
};

/// One surface, put together from the planes of the scans that see it.
struct LandmarkThickness {
  std::int32_t scan = 0, plane = 0;  ///< its plane with the smallest (scan, plane)
  std::size_t scans = 0;
  /// Laser points to the plane of all laser points of the landmark in the same cell, over the cells
  /// that several scans see (or all, where only one scan sees the landmark: its own noise).
  ThicknessSum laser_on_laser;
  /// The same points to the plane of their own scan's points in the cell: what scans at their best
  /// places would have.
  ThicknessSum within_scans;
  /// Drone points to that laser plane.
  ThicknessSum map_on_laser;
};

struct PlaneThickness {
  std::vector<LandmarkThickness> landmarks;                 ///< ascending by (scan, plane)
  ThicknessSum laser_on_laser, within_scans, map_on_laser;  ///< over landmarks of several scans;
                                                            ///< map_on_laser: over all
  double laser_median = 0.0, map_median = 0.0;  ///< of the landmarks' thickness, metres; NaN: none
  std::optional<Interval> laser_interval, map_interval;  ///< of the two rms; landmarks are blocks
};

/// Thickness of the planes of a map. Planes of different scans are one landmark where in a cell
/// they share (world axes, edge `cell`) their normals and distances agree within the gates, which
/// are those of the association of planes; so scans farther off than the gate count as two
/// surfaces, and a large number of landmarks beside few scans of each says so. Thickness is taken
/// cell by cell: no wall has to be flat over its whole length. Drone points count where their plane
/// in the cell agrees with the laser's within the wider gates; they never move the laser's plane.
PlaneThickness ComputePlaneThickness(const LabelledCloud& map,
                                     const PlaneThicknessOptions& options = {},
                                     double level = 0.95);

}  // namespace planegraph
