#pragma once

#include <string>
#include <vector>

#include "planegraph/correspondence/scan_model.h"
#include "planegraph/geometry/rigid3.h"

namespace planegraph {

/// How well a pose explains a scan's surfaces, as weighted shares of the source's samples.
struct Support {
  double agree = 0.0;    ///< a surface of the target lies there and faces the same way
  double violate = 0.0;  ///< the target's laser looked through the place
  double unknown = 0.0;  ///< the target did not see the place
  /// Sums of weight * n n^T over the agreeing and over the violating samples, n being their
  /// normals: which directions of translation the agreement stands for.
  Eigen::Matrix3d agree_by_direction = Eigen::Matrix3d::Zero();
  Eigen::Matrix3d violate_by_direction = Eigen::Matrix3d::Zero();

  double Score() const { return agree - violate; }
  /// Share of agreement among what was seen, in the direction where it is worst: a wrong pose may
  /// have the ground right and the walls wrong.
  double WorstDirection() const;
  /// Whether more than hardly any of the agreeing surfaces face along a unit vector (target frame).
  bool IsFaced(const Eigen::Vector3d& direction) const;
};

/// Compares the source's samples, under the pose, with the target's surfaces. `gate` is the largest
/// distance along the normal, metres.
Support MeasureSupport(const ScanModel& target, const ScanModel& source,
                       const Rigid3& target_from_source, double gate);

/// A candidate pose, and why it was dropped where it was.
struct PoseHypothesis {
  Rigid3 target_from_source;
  Support support;
  std::string rejected;  ///< empty: kept
};

struct HypothesisOptions {
  std::size_t most_rotations = 24;
  std::size_t peaks_per_axis = 16;
  std::size_t most_translations = 32;  ///< per rotation
  std::size_t most_verified = 32;      ///< by all samples, after a first look by few
  std::size_t most_kept = 12;          ///< hypotheses handed on, best first
  double gate = 0.4;                   ///< metres, of the coarse verification
  bool keep_rejected = false;          ///< list the dropped ones too, with the reason
};

/// Poses that would align two scans without any guess (ALGORITHMS: rotation first). Rotations come
/// from pairs of direction clusters with equal angles; with the rotation known every pair of
/// parallel planes votes for the translation along its normal, and the peaks of these
/// one-dimensional votes, found exactly by a sweep over the sorted votes, combine to translations.
/// Each is verified with the target's surfaces and its free space. Best first, distinct by 1 m or
/// 10 degrees.
std::vector<PoseHypothesis> FindHypotheses(const ScanModel& target, const ScanModel& source,
                                           const HypothesisOptions& options = {});

}  // namespace planegraph
