#pragma once

#include <memory>
#include <optional>
#include <string>

#include "planegraph/io/tile_file.h"
#include "planegraph/pipeline/map_front_end.h"
#include "planegraph/segmentation/map_segmenter.h"

namespace planegraph {

/// How much memory a map's cloud would take if it was read as a whole, bytes, by its header alone;
/// nothing where its file cannot be read in parts. Throws InputError.
std::optional<std::uint64_t> BytesAsAWhole(const std::string& cloud);

/// Moves a cloud, offset included; normals are turned along.
void MoveCloud(const Sim3& target_from_cloud, Cloud* cloud);

/// A map's cloud on disk.
struct TiledCloud {
  std::shared_ptr<TileFile> tiles;  ///< in the metric frame less `shift`
  Eigen::Vector3d shift = Eigen::Vector3d::Zero();
  DensitySample density{0};
  int threads = 1;  ///< that may segment tiles at the same time
  /// The memory that the fullest of the smallest tiles asks for where it is more than there is.
  std::optional<std::uint64_t> bytes_of_too_full;
};

/// Reads a cloud twice, part by part: for the number of points everywhere, and into tiles; three
/// times where its first point beyond 10 km, which gives all an offset, comes late. Tiles are those
/// of a map in memory, or halves, quarters and eighths where their points would take too much of
/// the memory. Throws InputError.
TiledCloud SpillCloud(const std::string& cloud, const Sim3& metric_from_map,
                      const MapMemory& memory, int threads);

}  // namespace planegraph
