#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "planegraph/cloud/cloud.h"
#include "planegraph/geometry/rigid3.h"

namespace planegraph {

struct ScanMergeOptions {
  double voxel = 0.0;      ///< edge of the thinning voxels, metres; 0: every point stays
  double min_range = 0.5;  ///< points nearer to the scan's origin are dropped, metres
  double max_range = 0.0;  ///< and those farther away; 0: none
};

/// A fingerprint (FNV-1a, 64 bits) of a sequence of clouds' points and their order, not of their
/// offsets.
inline constexpr std::uint64_t kFingerprintStart = 0xCBF29CE484222325ull;
std::uint64_t Fingerprint(const Cloud& cloud, std::uint64_t before = kFingerprintStart);

/// Puts raw scans into one cloud under given poses, each thinned in its own frame: of each voxel
/// floor(p / voxel) the first point in the scan's order stays, so that the same points stay
/// whatever the poses. What MME and thickness of a trajectory are taken of.
class ScanMerger {
 public:
  explicit ScanMerger(const ScanMergeOptions& options) : options_(options) {}
  /// Throws UsageError for a voxel so small that a scan's extent has too many.
  void Add(const Cloud& scan, const Rigid3& world_from_scan);
  /// Positions in the world; the offset is the translation of the first pose.
  const Cloud& merged() const { return merged_; }
  /// Of the points that stayed, in their scans' frames and in order: equal for equal sets of
  /// points, whatever the poses.
  std::uint64_t fingerprint() const { return fingerprint_; }

 private:
  ScanMergeOptions options_;
  std::optional<Eigen::Vector3d> offset_;
  Cloud merged_;
  std::uint64_t fingerprint_ = kFingerprintStart;
};

/// Indices of the first point of each occupied voxel, ascending.
std::vector<std::uint32_t> FirstOfEachVoxel(const Cloud& cloud, double voxel);

}  // namespace planegraph
