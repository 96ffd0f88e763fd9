#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <string>
#include <vector>

#include "report/viewer_input.h"

namespace planegraph {

/// The box that the view's coordinates are counted in, metres. Points outside, stray returns, are
/// not shown.
struct ViewerBox {
  Eigen::Vector3d low = Eigen::Vector3d::Zero();
  Eigen::Vector3d extent = Eigen::Vector3d::Ones();
};
ViewerBox ChooseViewerBox(const MapSample& sample, const std::vector<Eigen::Vector3d>& positions);

/// Points that follow each other and are of one scan.
struct ViewerRun {
  std::int32_t scan = -1;  ///< -1: of a drone map
  std::uint32_t count = 0;
};

/// Points as the page carries them.
struct ViewerPoints {
  std::vector<ViewerRun> runs;
  std::size_t count = 0;
  /// One column after the other, little-endian: x, y, z (uint16, of the box; each the difference to
  /// the one before), plane (uint16, 65535: none; likewise), all these first the low bytes and then
  /// the high ones; red, green, blue (uint8); residual (int8, in steps, -128: none).
  std::string columns;
  double residual_step = 0.001;  ///< metres
};

/// The residual is a point's distance to its plane: a laser's plane as segmentation found it in the
/// scan, a drone's as the sample's points give it.
ViewerPoints PackViewerPoints(const ReportData& data, const ViewerInput& input,
                              const ViewerBox& box);

}  // namespace planegraph
