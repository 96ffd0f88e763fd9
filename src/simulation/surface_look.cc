#include "simulation/surface_look.h"

#include <algorithm>
#include <cmath>

namespace planegraph {
namespace {

using Eigen::Vector3d;

constexpr std::uint64_t kTexture = 0x7e87, kHue = 0x4e1, kShade = 0x5ade;

// The value that a standard normal variable exceeds in the given share (Abramowitz and Stegun
// 26.2.23, error below 5e-4).
double UpperQuantile(double share) {
  if (share <= 0.0) return 1e9;
  if (share >= 0.5) return share >= 1.0 ? -1e9 : -UpperQuantile(1.0 - share);
  const double t = std::sqrt(-2.0 * std::log(share));
  return t - (2.515517 + t * (0.802853 + t * 0.010328)) /
                 (1.0 + t * (1.432788 + t * (0.189269 + t * 0.001308)));
}

// Hue, saturation and value, each in [0, 1], to red, green and blue in [0, 1].
Vector3d FromHsv(double hue, double saturation, double value) {
  const auto channel = [&](double shift) {
    const double k = std::fmod(shift + 6.0 * hue, 6.0);
    return value * (1.0 - saturation * std::clamp(std::min(k, 4.0 - k), 0.0, 1.0));
  };
  return {channel(5.0), channel(3.0), channel(1.0)};
}

// Ground and roofs rather grey, walls rather bright and warm, what is not planar green.
Vector3d BaseColor(std::uint64_t seed, const RayCaster::Hit& hit) {
  if (hit.label == kNotPlanar) return {0.30, 0.42, 0.20};
  const auto key = static_cast<std::uint64_t>(hit.label);
  const double hue = HashUniform(seed ^ kHue, key), shade = HashUniform(seed ^ kShade, key);
  if (hit.normal.z() > 0.97)
    return FromHsv(0.08 + 0.12 * hue, 0.05 + 0.2 * hue, 0.35 + 0.35 * shade);
  if (hit.normal.z() > 0.3) return FromHsv(0.02 * hue, 0.35 + 0.2 * hue, 0.45 + 0.2 * shade);
  return FromHsv(hue < 0.7 ? 0.15 * hue : hue, 0.25, 0.6 + 0.3 * shade);
}

}  // namespace

SurfaceLook::SurfaceLook(const PhotogrammetryOptions& options, std::uint64_t seed)
    : options_(options),
      seed_(seed),
      holes_(seed ^ 0x401e5, std::max(options.hole_size, 1e-3)),
      coarse_(seed ^ 0xc0a25e, 0.7),
      fine_(seed ^ 0xf14e, 0.12),
      hole_threshold_(UpperQuantile(options.hole_share)) {}

double SurfaceLook::KeptShare(const RayCaster::Hit& hit, const Vector3d& x_in_world) const {
  constexpr double kInHoles = 0.1, kUpright = 0.3;
  const double kept = holes_(x_in_world) > hole_threshold_ ? kInHoles : 1.0;
  const bool upright = hit.label != kNotPlanar && std::abs(hit.normal.z()) < kUpright;
  if (!upright) return kept;
  const double draw = HashUniform(seed_ ^ kTexture, static_cast<std::uint64_t>(hit.label));
  return draw < options_.poor_planes ? kept * options_.poor_kept : kept;
}

std::array<std::uint8_t, 3> SurfaceLook::Color(const RayCaster::Hit& hit,
                                               const Vector3d& x_in_world) const {
  const Vector3d to_sun = Vector3d(0.5, -0.6, 0.9).normalized();
  const double light = 0.55 + 0.45 * std::max(hit.normal.dot(to_sun), 0.0);
  const double texture = 1.0 + 0.07 * coarse_(x_in_world) + 0.06 * fine_(x_in_world);
  const Vector3d color = 255.0 * light * texture * BaseColor(seed_, hit);
  std::array<std::uint8_t, 3> bytes{};
  for (int k = 0; k < 3; ++k)
    bytes[k] = static_cast<std::uint8_t>(std::clamp(color[k], 0.0, 255.0));
  return bytes;
}

}  // namespace planegraph
