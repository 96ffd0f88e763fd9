#include "pipeline/map_tiles.h"

#include <algorithm>
#include <map>

#include "planegraph/base/error.h"
#include "planegraph/base/parallel.h"
#include "planegraph/io/cloud_parts.h"

namespace planegraph {
namespace {

// Measured: a point in a cloud with its attributes and its share in the tile that is segmented;
// in a tile that is segmented, with a half to spare.
constexpr std::uint64_t kBytesOfPoint = 64, kBytesInSegmentation = 160;
constexpr int kMostHalvings = 3;

// Parts of the cloud in the frame of its planes.
class MovedParts {
 public:
  MovedParts(const std::string& cloud, const Sim3& metric_from_map)
      : parts_(cloud, kPart, CloudParts::Offset::kOnTheWay), metric_from_map_(metric_from_map) {}

  bool Next(Cloud* part) {
    if (!parts_.Next(part)) return false;
    MoveCloud(metric_from_map_, part);
    shift_ = part->offset;
    part->viewpoint -= part->offset;
    part->offset.setZero();
    part->intensities.clear();
    return true;
  }
  void Rewind() { parts_.Rewind(); }
  bool OffsetCameLate() const { return parts_.OffsetCameLate(); }
  const Eigen::Vector3d& shift() const { return shift_; }

 private:
  static constexpr std::size_t kPart = 65536;
  CloudParts parts_;
  Sim3 metric_from_map_;
  Eigen::Vector3d shift_ = Eigen::Vector3d::Zero();
};

// Points by the smallest tiles that there may be.
struct Census {
  std::map<TileKey, std::size_t> points;
  std::size_t total = 0;
  bool has_normals = false, has_colors = false;

  std::uint64_t ScratchBytes() const {
    return total * TileFile::BytesOfPoint(has_normals, has_colors);
  }
};

Census Count(MovedParts* parts) {
  constexpr double kEdge = MapSegmentationOptions::kTile / (1 << kMostHalvings);
  Census census;
  Cloud part;
  while (parts->Next(&part)) {
    std::optional<TileKey> last;
    std::size_t* at = nullptr;
    for (const Eigen::Vector3f& point : part.points) {
      const TileKey key = TileOf(point, kEdge);
      if (key != last) at = &census.points[key];
      last = key;
      ++*at;
    }
    census.total += part.size();
    census.has_normals = census.has_normals || !part.normals.empty();
    census.has_colors = census.has_colors || !part.colors.empty();
  }
  const bool again = parts->OffsetCameLate();
  parts->Rewind();
  return again ? Count(parts) : census;
}

// Points of the fullest tile, whose edge is 2^doublings of the smallest.
std::size_t Fullest(const Census& census, int doublings) {
  std::map<TileKey, std::size_t> tiles;
  std::size_t most = 0;
  for (const auto& [key, points] : census.points) {
    std::size_t& sum = tiles[{key.first >> doublings, key.second >> doublings}];
    most = std::max(most, sum += points);
  }
  return most;
}

// The largest tiles that fit, or the smallest that there may be.
int DoublingsFor(const Census& census, std::uint64_t most_points) {
  for (int doublings = kMostHalvings; doublings > 0; --doublings) {
    if (Fullest(census, doublings) <= most_points) return doublings;
  }
  return 0;
}

}  // namespace

std::optional<std::uint64_t> BytesAsAWhole(const std::string& cloud) {
  const auto extent = CloudParts::Measure(cloud);
  if (!extent) return {};
  return extent->bytes + kBytesOfPoint * extent->points;
}

void MoveCloud(const Sim3& target_from_cloud, Cloud* cloud) {
  const Eigen::Vector3d offset = (target_from_cloud * cloud->offset).array().round();
  const Sim3 moved(target_from_cloud.scale, target_from_cloud.rotation,
                   target_from_cloud * cloud->offset - offset);
  const Eigen::Matrix3d turn = moved.scale * moved.rotation.toRotationMatrix();
  for (auto& point : cloud->points) {
    point = (turn * point.cast<double>() + moved.translation).cast<float>();
  }
  const Eigen::Matrix3f rotation = moved.rotation.toRotationMatrix().cast<float>();
  for (auto& normal : cloud->normals) normal = (rotation * normal).eval();
  cloud->viewpoint = target_from_cloud * cloud->viewpoint;
  cloud->offset = offset;
}

TiledCloud SpillCloud(const std::string& cloud, const Sim3& metric_from_map,
                      const MapMemory& memory, int threads) {
  MovedParts parts(cloud, metric_from_map);
  const Census census = Count(&parts);
  if (census.total == 0) throw InputError::InFile(cloud, "holds no points (that are finite)");
  CheckScratchRoom(memory.scratch, census.ScratchBytes());
  // A half for the tiles at work; the planes need room, too.
  const std::uint64_t most = std::max<std::uint64_t>(memory.bytes / 2 / kBytesInSegmentation, 1);
  const int doublings = DoublingsFor(census, most);
  const double edge = MapSegmentationOptions::kTile / (1 << (kMostHalvings - doublings));
  TiledCloud tiled;
  tiled.tiles = std::make_shared<TileFile>(memory.scratch, edge, memory.bytes / 4);
  tiled.density = DensitySample(census.total);
  Cloud part;
  while (parts.Next(&part)) {
    tiled.density.Add(part);
    tiled.tiles->Add(part);
  }
  tiled.tiles->Finish();
  tiled.shift = parts.shift();
  const std::size_t fullest = tiled.tiles->PointsOfLargest();
  if (fullest > most) tiled.bytes_of_too_full = 2 * kBytesInSegmentation * fullest;
  const std::uint64_t at_once = most / std::max<std::size_t>(fullest, 1);
  tiled.threads = static_cast<int>(
      std::clamp<std::uint64_t>(at_once, 1, static_cast<std::uint64_t>(ResolveThreads(threads))));
  return tiled;
}

}  // namespace planegraph
