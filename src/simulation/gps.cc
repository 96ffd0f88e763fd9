#include "planegraph/simulation/gps.h"

#include <algorithm>
#include <cmath>

#include "planegraph/base/error.h"

namespace planegraph {
namespace {

using Eigen::Vector3d;

Vector3d Normals(const Vector3d& sigma, Random* random) {
  Vector3d result;
  for (int k = 0; k < 3; ++k) result[k] = sigma[k] * random->Normal();
  return result;
}

}  // namespace

Vector3d PositionAt(const Flight& flight, double time) {
  const auto& times = flight.times;
  const std::size_t next = std::upper_bound(times.begin(), times.end(), time) - times.begin();
  if (next == 0) return flight.world_from_camera.front().translation;
  if (next == times.size()) return flight.world_from_camera.back().translation;
  const double share = (time - times[next - 1]) / (times[next] - times[next - 1]);
  return (1.0 - share) * flight.world_from_camera[next - 1].translation +
         share * flight.world_from_camera[next].translation;
}

SimulatedGps SimulateGps(const Flight& flight, const GpsOptions& options, Random* random) {
  if (!(options.period > 0.0 && options.drift_time > 0.0)) {
    throw UsageError("GPS needs a period and a correlation time > 0");
  }
  SimulatedGps track;
  if (flight.times.empty()) return track;
  track.bias = Normals(options.bias_sigma, random);
  Vector3d drift = Normals(options.drift_sigma, random);
  const double kept = std::exp(-options.period / options.drift_time);
  const double duration = flight.times.back() - flight.times.front();
  constexpr double kMostFixes = 1e7;
  if (duration / options.period > kMostFixes)
    throw UsageError("a GPS track of more than 1e7 fixes");
  const int count = 1 + static_cast<int>(std::floor(duration / options.period));
  for (int i = 0; i < count; ++i) {
    const double time = flight.times.front() + i * options.period;
    if (i > 0)
      drift = kept * drift + std::sqrt(1.0 - kept * kept) * Normals(options.drift_sigma, random);
    Vector3d error = track.bias + drift + Normals(options.white_sigma, random);
    const bool outlier = random->Chance(options.outlier_share);
    const Vector3d jump = Normals(Vector3d::Constant(options.outlier_size), random);
    if (outlier) error += jump;
    track.times.push_back(time);
    track.positions.emplace_back(PositionAt(flight, time) + error);
  }
  return track;
}

}  // namespace planegraph
