#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

namespace planegraph {

/// One estimate, aligned, and its errors.
struct PlotSeries {
  std::string name;                        ///< in the legend
  std::vector<Eigen::Vector3d> positions;  ///< metres, the reference's frame
  std::vector<double> ate;                 ///< metres, one per pose
  std::vector<double> rpe_times;           ///< of the later pose of each pair
  std::vector<double> rpe, rpe_rotation;   ///< metres and degrees, one per pair
};

struct TrajectoryPlot {
  std::vector<Eigen::Vector3d> reference;  ///< metres
  std::vector<double> times;               ///< of its poses, seconds or indices
  bool has_times = true;
  std::string ate_title, rpe_title;  ///< name the conventions
  std::vector<PlotSeries> series;
};

/// A gnuplot script that draws, to its standard output, the trajectories seen along the axis in
/// which they spread least, and the errors over time. `format`: "svg" or "pdf".
std::string GnuplotScript(const TrajectoryPlot& plot, const std::string& format);

}  // namespace planegraph
