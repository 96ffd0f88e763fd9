#pragma once

#include <string>
#include <utility>
#include <vector>

#include "planegraph/evaluation/statistics.h"
#include "planegraph/geometry/sim3.h"
#include "planegraph/io/trajectory_io.h"

namespace planegraph {

// Absolute and relative errors of a trajectory (Sturm et al. 2012, "A benchmark for the evaluation
// of RGB-D SLAM systems"), with the conventions of the tool evo, whose figures these reproduce.
// Metres and radians throughout.

/// A pose as a matrix. Files with matrices (KITTI) hold rotations that are not quite orthonormal;
/// errors of a hundredth of a millimetre depend on taking them as they stand.
struct MatrixPose {
  Eigen::Matrix3d rotation = Eigen::Matrix3d::Identity();
  Eigen::Vector3d translation = Eigen::Vector3d::Zero();
};

/// Pose k of the estimate belongs to pose k of the reference.
struct PosePairs {
  std::vector<MatrixPose> reference, estimate;  ///< world_from_body, of equal length
  bool by_time = true;                          ///< false: paired by index
  double max_time_difference = 0.0;             ///< the largest that occurs, seconds
  std::size_t unpaired = 0;          ///< poses of the shorter trajectory without a counterpart
  std::vector<double> times;         ///< of the reference's poses; without times their indices
  std::vector<std::size_t> indices;  ///< of the reference's poses, in its file
  std::vector<std::size_t> estimate_indices;  ///< likewise of the estimate's
};

/// Pairs two trajectories. Both with times: each pose of the shorter one takes the pose of the
/// other that is nearest in time, where that is at most `max_difference` seconds away. Otherwise by
/// index; unequal counts are then an InputError about `estimate_name`. Throws NoResultError where
/// nothing pairs.
PosePairs PairPoses(const Trajectory& reference, const Trajectory& estimate,
                    double max_difference = 0.01, const std::string& estimate_name = "estimate");

/// How the estimate is laid over the reference before the errors are taken.
enum class PoseAlignment {
  kSe3,    ///< least squares of the positions, rotation and translation (Horn, Umeyama)
  kSim3,   ///< the same with scale
  kFirst,  ///< the first pair of poses made equal
  kNone
};
/// "se3", "sim3", "first", "none". Throws UsageError for another name.
PoseAlignment ParsePoseAlignment(const std::string& name);
std::string Name(PoseAlignment alignment);

/// The reference frame from the estimate's. kSe3 and kSim3 need positions that spread in at least
/// two directions: NoResultError says so where all lie on a line, that is where their spread across
/// it is below 1 % of that along it and also below 5 cm or three times the misfit.
Sim3 AlignPoses(const PosePairs& pairs, PoseAlignment alignment);

/// Errors of position and of rotation. The rotation's are angles in [0, pi].
struct PoseErrors {
  Statistics translation, rotation;
  std::size_t count = 0;                                    ///< poses (ATE) or pairs of poses (RPE)
  std::vector<double> translation_errors, rotation_errors;  ///< one per pose or pair
};

struct AteResult {
  PoseErrors errors;
  PoseAlignment alignment = PoseAlignment::kSe3;
  Sim3 reference_from_estimate;
};

/// Absolute trajectory error: of F_i = Q_i^-1 S P_i, reference Q, estimate P, alignment S.
AteResult ComputeAte(const PosePairs& pairs, PoseAlignment alignment);

/// The estimate's pose k in the frame of the reference.
std::vector<MatrixPose> AlignedEstimate(const PosePairs& pairs, const AteResult& ate);

enum class DeltaUnit { kFrames, kMetres };
struct RpeOptions {
  double delta = 1.0;  ///< frames (a whole number) or metres of path; above 0
  DeltaUnit unit = DeltaUnit::kFrames;
  /// False: disjoint consecutive pairs (0, d), (d, 2d), ...; true: a pair from every pose.
  bool all_pairs = false;
  /// Metres are counted along the path of the estimate instead of the reference's.
  bool pairs_from_estimate = false;
  /// With all_pairs in metres: the path between two poses may differ from delta by this share of
  /// it.
  double relative_tolerance = 0.1;
};

struct RpeResult {
  PoseErrors errors;
  RpeOptions options;
  std::vector<std::pair<std::size_t, std::size_t>> pairs;  ///< of poses, one per error
};

/// Pairs (i, j) of poses about delta apart. In metres and disjoint, a pair reaches from the first
/// pose at which delta has been covered since the last such pose to the next one; in metres and
/// all, from every pose to the one whose distance along the path comes nearest to delta.
std::vector<std::pair<std::size_t, std::size_t>> SelectPairs(const std::vector<MatrixPose>& poses,
                                                             const RpeOptions& options);

/// Relative pose error: of E = (Q_i^-1 Q_j)^-1 (P_i^-1 P_j) over the selected pairs. A rigid
/// alignment leaves it as it is; the estimate's positions are multiplied by `scale` first (the
/// scale of a sim3 alignment, else 1). Throws NoResultError where no two poses are delta apart, and
/// UsageError where delta makes no sense.
RpeResult ComputeRpe(const PosePairs& pairs, const RpeOptions& options, double scale = 1.0);

/// The ATE without one block of consecutive poses each, for intervals (interval.h). The alignment
/// by positions is found anew each time, so its freedom counts; those by the first pose and none
/// stay. Empty where an alignment fails.
std::vector<PoseErrors> AteWithoutBlocks(const PosePairs& pairs, const AteResult& ate,
                                         std::size_t blocks);
/// Likewise the RPE without one block of consecutive pairs each. Blocks are at least as long as the
/// pairs' reach, for pairs that overlap share their errors.
std::vector<PoseErrors> RpeWithoutBlocks(const RpeResult& rpe, std::size_t blocks);

}  // namespace planegraph
