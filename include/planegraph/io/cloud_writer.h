#pragma once

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <string>

#include "planegraph/base/atomic_file.h"
#include "planegraph/cloud/cloud.h"

namespace planegraph {

/// Where a point of a merged map comes from.
enum class PointSource : std::uint8_t { kLaser = 0, kVision = 1 };

/// Writes a merged map (map.ply) point by point, of any number that need not be known before:
/// binary little-endian PLY with float x y z, uchar red green blue, uchar source, int scan, int
/// plane, and the comment `offset X Y Z` in full digits. ReadCloud reads it back. Holds about 1.5
/// MB, whatever the size of the map. Throws InputError where the file cannot be written.
class MapPlyWriter {
 public:
  /// `offset`: what is to be added to the points' floats, metres.
  MapPlyWriter(const std::string& path, const Eigen::Vector3d& offset);

  /// Adds the point at offset + `position`; `scan` and `plane` are -1 where there is none.
  void Add(const Eigen::Vector3f& position, const std::array<std::uint8_t, 3>& rgb,
           PointSource source, std::int32_t scan, std::int32_t plane) {
    if (filled_ == buffer_.size()) Flush();
    char* out = buffer_.data() + filled_;
    CopyTo(out, position.data(), 12);
    CopyTo(out + 12, rgb.data(), 3);
    out[15] = static_cast<char>(source);
    CopyTo(out + 16, &scan, 4);
    CopyTo(out + 20, &plane, 4);
    filled_ += kRecordBytes;
  }
  /// Number of points so far.
  std::uint64_t count() const { return flushed_ + filled_ / kRecordBytes; }
  /// Completes the file and puts it in its place. Without it nothing is left behind.
  void Commit();

 private:
  static constexpr std::size_t kRecordBytes = 24;

  static void CopyTo(char* to, const void* from, std::size_t bytes) {
    std::memcpy(to, from, bytes);
  }
  void Flush();

  AtomicFile file_;
  Eigen::Vector3d offset_;
  std::string buffer_;
  std::size_t filled_ = 0;
  std::uint64_t flushed_ = 0;
};

/// A merged map by where its points come from.
struct MergedMap {
  Cloud laser;   ///< positions alone
  Cloud vision;  ///< with colours
};

inline constexpr std::size_t kEveryPoint = static_cast<std::size_t>(-1);

/// Reads map.ply back, a block at a time. Of more than `most` points of lasers, or of drones, every
/// second one stays, or every fourth, and so on. The points of any other PLY are the laser's, all
/// of them. Points with a NaN or infinite coordinate are dropped. Throws InputError.
MergedMap ReadMapPly(const std::string& path, std::size_t most = kEveryPoint);

/// A point of a merged map with all that map.ply says of it.
struct MapPlyPoint {
  Eigen::Vector3f position = Eigen::Vector3f::Zero();  ///< less the map's offset
  std::array<std::uint8_t, 3> rgb = {0, 0, 0};
  PointSource source = PointSource::kLaser;
  std::int32_t scan = -1, plane = -1;  ///< -1: none
};

/// Some points of a merged map, in its order.
struct MapSample {
  Eigen::Vector3d offset = Eigen::Vector3d::Zero();
  std::vector<MapPlyPoint> points;
  std::uint64_t total = 0;  ///< points of the whole map
};

/// At most `most` points of map.ply, one at random from each stretch of equal length, the same in
/// every run; a block of the file is in memory at a time. Points with a NaN or infinite coordinate
/// are dropped. Empty where the file is not there or not one that MapPlyWriter wrote, and what a
/// file that is cut off still holds: ReadMapPly says what is wrong with it.
MapSample SampleMapPly(const std::string& path, std::size_t most);

}  // namespace planegraph
