#pragma once

#include <string>

#include "planegraph/pipeline/mapper.h"

namespace planegraph {

struct OutputOptions {
  std::string folder;
  double map_voxel =
      0.05;  ///< metres: of each scan the first point of a voxel stays; 0: all points
  int threads = 0;
};

/// Writes the trajectories (TUM, 3DTK .frames), the graph (g2o), the planes and the merged map of a
/// run into its folder. Every file appears whole or not at all. Throws InputError.
void WriteOutputs(const MapResult& result, const OutputOptions& options);

/// The run as JSON text (INTERFACE: report.json) without the version stamp.
std::string ReportJson(const MapResult& result, const MapOptions& options);

}  // namespace planegraph
