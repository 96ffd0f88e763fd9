#include "solve/shared_directions.h"

#include <algorithm>
#include <cmath>

namespace planegraph {
namespace {

constexpr double kSameDirection = 0.966;  // 15 deg

}  // namespace

std::vector<std::size_t> DirectionsOf(const std::vector<SharedLandmark>& shared) {
  std::vector<Eigen::Vector3d> directions;
  std::vector<std::size_t> direction_of;
  for (const SharedLandmark& s : shared) {
    const auto found = std::find_if(
        directions.begin(), directions.end(),
        [&](const Eigen::Vector3d& d) { return d.dot(s.target_normal) > kSameDirection; });
    direction_of.push_back(static_cast<std::size_t>(found - directions.begin()));
    if (found == directions.end()) directions.push_back(s.target_normal);
  }
  return direction_of;
}

std::vector<double> WeightsOf(const std::vector<std::size_t>& direction_of) {
  std::vector<double> counts(direction_of.size(), 0.0), weights;
  for (const std::size_t d : direction_of) counts[d] += 1.0;
  for (const std::size_t d : direction_of) weights.push_back(1.0 / std::sqrt(counts[d]));
  return weights;
}

}  // namespace planegraph
