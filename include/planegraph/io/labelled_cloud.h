#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "planegraph/cloud/cloud.h"

namespace planegraph {

/// Positions with what map.ply, or the labelled cloud of `segment`, says of each point. All vectors
/// are as long as the points.
struct LabelledCloud {
  Cloud cloud;                       ///< positions alone
  std::vector<std::int32_t> planes;  ///< of the point's scan or drone map; -1: none
  std::vector<std::int32_t> scans;   ///< 0 where the file has no `scan`
  std::vector<std::uint8_t> vision;  ///< 1: from images; 0 where the file has no `source`
};

/// Reads a binary little-endian PLY whose vertices have float x y z and an int `plane`. Nothing for
/// any other file. Points that are not finite are dropped. Throws InputError where the file cannot
/// be read or is cut short.
std::optional<LabelledCloud> ReadLabelledCloud(const std::string& path);

}  // namespace planegraph
