#pragma once

#include <string>
#include <vector>

#include "planegraph/cloud/cloud.h"
#include "planegraph/segmentation/segmenter.h"

namespace planegraph::tools {

/// The flags of how a cloud is read and segmented, for Command::flags.
std::vector<std::string> SegmentationFlags();

/// The value of a flag --NAME=laser|vision. Throws UsageError.
CloudKind ParseKind(const std::string& flag, const std::string& value);

/// Reads the cloud in the format that --format says. Throws InputError.
Cloud ReadInputCloud(const std::string& path);

/// Segments a cloud as the flags say. The labels are those of all points of `cloud`: those nearer
/// than --min_range to a laser's viewpoint get -1. Throws UsageError, and InputError in the name of
/// `path` where the cloud's extent is too large.
Segmentation SegmentInput(const Cloud& cloud, CloudKind kind, const std::string& path);

/// The planes of a cloud (metres per unit: `scale`) or of a PLANES.json, by the ending. Warns on
/// stderr of a scan whose unit may not be the metre.
PlaneSet LoadPlanes(const std::string& path, CloudKind kind, double scale);

/// True where the path names a PLANES.json.
bool IsPlanesFile(const std::string& path);

/// Metres per unit of a drone map.
struct ScaleOfMap {
  double scale = 1.0, sigma = 0.0;  // metres per unit; relative
};
/// Reads --map_scale: S, or S:SIGMA with both in metres per unit; empty: 1. Throws UsageError.
ScaleOfMap ParseMapScale(const std::string& text);

/// The numbers of a text like 1,2.5,-3. Throws UsageError in the name of the flag.
std::vector<double> ParseNumbers(const std::string& flag, const std::string& text);

}  // namespace planegraph::tools
