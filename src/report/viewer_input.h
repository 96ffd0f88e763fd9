#pragma once

#include <Eigen/Core>
#include <string>
#include <string_view>
#include <vector>

#include "planegraph/io/cloud_writer.h"
#include "report/report_data.h"

namespace planegraph {

/// A plane of a scan as the 3-D view shows it, in the scan's frame, metres.
struct ViewerPlane {
  Eigen::Vector3d normal = Eigen::Vector3d::UnitZ();
  double distance = 0.0;  ///< normal . x = distance
  double area = 0.0;      ///< m^2
  double rms = 0.0;       ///< of its points, metres
  std::vector<Eigen::Vector3d> hull;
};

/// What the 3-D view is made of, besides the report itself.
struct ViewerInput {
  MapSample sample;
  std::vector<std::vector<ViewerPlane>> planes;  ///< of each scan, by the plane's number
  std::string_view script;                       ///< empty: this build has no viewer
};

/// Reads a run's folder: points of map.ply up to the viewer's budget and planes/*.json. Files that
/// are not there are left out; one that is no JSON is an InputError. Plane numbers without a usable
/// plane have an empty hull.
ViewerInput ReadViewerInput(const std::string& folder, const ReportData& data);

}  // namespace planegraph
