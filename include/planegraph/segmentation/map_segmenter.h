#pragma once

#include "planegraph/segmentation/segmenter.h"

namespace planegraph {

/// What a photogrammetric map's own density asks for: cells of some nine points, and the
/// correlation lengths and systematic floors of multi-view stereo (ALGORITHMS 1.7). The cloud is in
/// metres.
SegmentationOptions VisionOptions(const Cloud& cloud);

struct MapSegmentationOptions {
  SegmentationOptions segmentation;
  double tile = 25.6;  ///< edge of a tile in x and y, metres
  int threads = 1;     ///< 0: all cores; the result is the same for each number
};

/// Planes of a large cloud, segmented once as a whole: tile by tile in x and y, so that beside the
/// cloud itself no more than a tile for each thread is in memory. A plane that goes on in the next
/// tile is two; its patches, which registration works on, do not notice. Labels are those of the
/// whole.
Segmentation SegmentMap(const Cloud& cloud, const MapSegmentationOptions& options);

}  // namespace planegraph
