#pragma once

#include <functional>

#include "planegraph/cloud/cloud_tiles.h"
#include "planegraph/segmentation/segmenter.h"

namespace planegraph {

/// What a photogrammetric map's own density asks for: cells of some nine points, and the
/// correlation lengths and systematic floors of multi-view stereo (ALGORITHMS 1.7). The cloud is in
/// metres.
SegmentationOptions VisionOptions(const Cloud& cloud);

/// Points of a cloud that are looked at for its density: equally spaced in its order, 150 000 to
/// 300 000 of a large one.
class DensitySample {
 public:
  /// `total`: points of the whole cloud.
  explicit DensitySample(std::size_t total);
  /// The cloud in parts of any size, in its order.
  void Add(const Cloud& part);
  /// Points per square metre of surface: the median over a few places.
  double PerSquareMetre() const;

 private:
  std::size_t stride_, seen_ = 0;
  std::vector<Eigen::Vector3f> points_;
};
/// Likewise, of a cloud that is not in memory.
SegmentationOptions VisionOptions(const DensitySample& sample);

struct MapSegmentationOptions {
  static constexpr double kTile = 25.6;
  SegmentationOptions segmentation;
  double tile = kTile;  ///< edge of a tile in x and y, metres
  int threads = 1;      ///< 0: all cores; the result is the same for each number
  /// Of a larger cloud the noise is measured on tiles with about as many points.
  std::size_t noise_points = 2000000;
};

/// Planes of a large cloud, segmented once as a whole: tile by tile in x and y, so that beside the
/// cloud itself no more than a tile for each thread is in memory. A plane that goes on in the next
/// tile is two; its patches, which registration works on, do not notice. Labels are those of the
/// whole.
Segmentation SegmentMap(const Cloud& cloud, const MapSegmentationOptions& options);

/// Takes the labels of a tile's points; tiles come in order, by one thread.
using TakeLabels = std::function<void(std::size_t tile, std::vector<std::int32_t> labels)>;

/// The same of a cloud that is there tile by tile (`options.tile` is not looked at): as many tiles
/// as threads are in memory, and nothing of a tile's points stays.
PlaneSet SegmentTiles(const CloudTiles& tiles, const MapSegmentationOptions& options,
                      const TakeLabels& take);

}  // namespace planegraph
