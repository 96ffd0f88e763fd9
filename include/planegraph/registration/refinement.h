#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "planegraph/correspondence/hypotheses.h"
#include "planegraph/correspondence/scan_model.h"

namespace planegraph {

/// 6x6 in the order x y z rx ry rz, decoupled left perturbation in the target's axes.
using Matrix6d = Eigen::Matrix<double, 6, 6>;

/// A guess with what is known of its error, as a soft prior in every direction.
struct PosePrior {
  Rigid3 target_from_source;
  Matrix6d covariance;  ///< INTERFACE order, metres and radians
};

struct RefinementOptions {
  double first_gate = 0.5;  ///< metres along the normal, of the first association
  double last_gate = 0.05;  ///< metres, of the last one
  int most_iterations = 25;
  double floor_offset = 0.002;      ///< least systematic error of a surfel's height, metres
  std::size_t most_surfels = 2000;  ///< of the source that take part, evenly spread
};

/// A plane of the target and a plane of the source that are one under the pose.
struct PlanePair {
  std::int32_t target, source;  ///< indices into PlaneSet::planes
  int surfels;                  ///< pairs of surfels that say so
};

/// A pose refined by the surfaces, with what they say of it.
struct Refinement {
  Rigid3 target_from_source;
  Matrix6d information = Matrix6d::Zero();  ///< of the surfaces alone, without the prior
  /// Information that noise of the normals alone would fake, by direction of translation
  /// (ALGORITHMS 3.2: sum of w_i C_nn,i).
  Eigen::Matrix3d spurious = Eigen::Matrix3d::Zero();
  double floor = 0.0;       ///< height error that the noise model does not explain, metres
  double tilt_floor = 0.0;  ///< likewise of the planes' normals, radians
  double rms = 0.0;         ///< of the residuals, metres
  double tilt_rms = 0.0;    ///< of the angles between paired planes, radians; 0: too few to tell
  /// Covariance (INTERFACE order) with the floor as an error that all surfels of one segment share:
  /// a bent scan does not average out over the points of a wall. Singular directions: see Register.
  Matrix6d covariance = Matrix6d::Zero();
  std::vector<PlanePair> correspondences;  ///< most surfels first
  int pairs = 0;                           ///< of surfels
  int iterations = 0;
  bool converged = false;
};

/// Iterated association of surfels and weighted Gauss-Newton on their plane-to-plane heights, from
/// a wide gate to a narrow one; Geman-McClure weights at the width of the gate. The six unknowns
/// are solved jointly; directions that the surfaces leave open stay where the prior (or the start)
/// has them.
Refinement RefinePose(const ScanModel& target, const ScanModel& source,
                      const Rigid3& target_from_source, const RefinementOptions& options = {},
                      const std::optional<PosePrior>& prior = {});

/// Whether a direction of translation (unit, target's axes) is really observed: the cost that rises
/// when the pose is shifted by +-`shift` metres along it and every surface looks for its partner
/// anew, as a share of the rise that the linearized information predicts. Near one where surfaces
/// face along the direction; near zero where only the noise of many normals does, as in a corridor.
double ObservedShare(const ScanModel& target, const ScanModel& source, const Refinement& refinement,
                     const Eigen::Vector3d& direction, double shift,
                     const RefinementOptions& options = {});

}  // namespace planegraph
