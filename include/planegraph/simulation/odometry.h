#pragma once

#include <vector>

#include "planegraph/geometry/rigid3.h"
#include "planegraph/simulation/random.h"

namespace planegraph {

/// Errors of wheel odometry with a gyroscope. Scale and yaw drift are drawn once per run, each with
/// a random sign; the rest is drawn anew at each step.
struct OdometryOptions {
  double scale_min = 0.01, scale_max = 0.02;  ///< systematic error of lengths, relative
  double yaw_drift_min = 0.00035, yaw_drift_max = 0.00087;  ///< radians per metre (0.02-0.05 deg)
  double yaw_sigma = 0.00436;  ///< radians per square root of a metre (0.25 deg)
  double turn_sigma = 0.02;    ///< of turned angles, relative
  double tilt_sigma = 0.0035;  ///< roll and pitch, radians per step (0.2 deg)
  double step_sigma = 0.01;    ///< each axis, metres per step
  double forward_sigma = 0.012, lateral_sigma = 0.008, vertical_sigma = 0.004;  ///< of the length
};

/// Odometry of a run with the poses world_from_scan: accumulated disturbed relative motion, the
/// first pose identity.
std::vector<Rigid3> SimulateOdometry(const std::vector<Rigid3>& truth,
                                     const OdometryOptions& options, Random* random);

}  // namespace planegraph
