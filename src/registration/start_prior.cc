#include "registration/start_prior.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "planegraph/geometry/rotation.h"

namespace planegraph {
namespace {

constexpr double kWrongStart = 0.1;
constexpr double kSigmas = 3.0;       // the window that is searched, either way
constexpr double kLeastSigma = 1e-3;  // metres or radians

// Log of a normal density, cut off at `reach` either way, over the even one.
double LogRatio(double off, double sigma, double reach) {
  sigma = std::max(sigma, kLeastSigma);
  const double inside = std::erf(reach / (std::numbers::sqrt2 * sigma));
  const double even = 2.0 * reach / (std::sqrt(2.0 * std::numbers::pi) * sigma * inside);
  return std::log(even) - 0.5 * off * off / (sigma * sigma);
}

}  // namespace

double LogStartRatio(const Eigen::Vector3d& extent, const MapPrior& prior,
                     const Sim3& map_from_group) {
  if (!prior.pose) return 0.0;
  const MapPrior::Pose& start = *prior.pose;
  const Eigen::Vector3d off = map_from_group.translation - start.map_from_group.translation;
  const Eigen::Vector3d turn =
      LogSO3(map_from_group.rotation * start.map_from_group.rotation.conjugate());
  const double metres = std::max(start.sigma_translation, kLeastSigma);
  const double radians = std::max(start.sigma_rotation, kLeastSigma);
  const double around = std::min(std::sqrt(3.0) * kSigmas * radians, std::numbers::pi);
  double log_ratio = 0.0;
  for (int axis = 0; axis < 3; ++axis) {
    const bool settled = prior.upright;
    if (!settled || axis != 2) {
      log_ratio += LogRatio(off[axis], metres, std::min(kSigmas * metres, 0.5 * extent[axis]));
    }
    if (!settled || axis == 2) log_ratio += LogRatio(turn[axis], radians, around);
  }
  return std::log((1.0 - kWrongStart) * std::exp(log_ratio) + kWrongStart);
}

}  // namespace planegraph
