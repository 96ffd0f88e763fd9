#include "planegraph/simulation/odometry.h"

#include <cmath>

#include "planegraph/geometry/rotation.h"

namespace planegraph {
namespace {

// What stays the same over a run.
struct Drift {
  double scale, yaw;
};

Rigid3 Disturb(const Rigid3& motion, const OdometryOptions& o, const Drift& drift, Random* random) {
  const double length = motion.translation.norm();
  const double turned = LogSO3(motion.rotation).norm();
  const Eigen::Vector3d relative(o.forward_sigma, o.lateral_sigma, o.vertical_sigma);
  Rigid3 result = motion;
  result.translation *= drift.scale;
  for (int k = 0; k < 3; ++k) {
    result.translation[k] += (o.step_sigma + relative[k] * length) * random->Normal();
  }
  const double walk = o.yaw_sigma * std::sqrt(length) * random->Normal();
  const double slip = o.turn_sigma * turned * random->Normal();
  const double yaw = drift.yaw * length + walk + slip;
  const double roll = o.tilt_sigma * random->Normal();
  const double pitch = o.tilt_sigma * random->Normal();
  result.rotation = (motion.rotation * ExpSO3({roll, pitch, yaw})).normalized();
  return result;
}

}  // namespace

std::vector<Rigid3> SimulateOdometry(const std::vector<Rigid3>& truth,
                                     const OdometryOptions& options, Random* random) {
  Drift drift{random->Uniform(options.scale_min, options.scale_max),
              random->Uniform(options.yaw_drift_min, options.yaw_drift_max)};
  drift.scale = 1.0 + random->Sign() * drift.scale;
  drift.yaw *= random->Sign();
  std::vector<Rigid3> odometry(truth.size());
  for (std::size_t k = 1; k < truth.size(); ++k) {
    const Rigid3 motion = truth[k - 1].Inverse() * truth[k];
    odometry[k] = odometry[k - 1] * Disturb(motion, options, drift, random);
  }
  return odometry;
}

}  // namespace planegraph
