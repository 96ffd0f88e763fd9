#include "planegraph/simulation/flight.h"

#include <algorithm>
#include <cmath>

#include "planegraph/base/error.h"
#include "planegraph/geometry/rotation.h"

namespace planegraph {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr int kMostImages = 5000;

void CheckOptions(const FlightOptions& o) {
  const PinholeCamera& c = o.camera;
  if (c.width < 1 || c.height < 1 || c.width > 20000 || c.height > 20000 || !(c.focal > 0.0)) {
    throw UsageError("the drone's camera needs a size of 1 to 20000 pixels and a focal length > 0");
  }
  const auto share = [](double overlap) { return overlap >= 0.0 && overlap < 1.0; };
  if (!share(o.overlap_along) || !share(o.overlap_across)) {
    throw UsageError("the overlaps of a flight must lie in [0, 1)");
  }
  const auto number = [](int images) { return images >= 0 && images <= kMostImages; };
  if (!(o.height > 0.0 && o.speed > 0.0 && std::isfinite(o.height)) || !number(o.ring_images) ||
      !number(o.inner_ring_images)) {
    throw UsageError("a flight needs a height and a speed > 0, and at most 5000 images");
  }
}

// A camera that looks along `forward`, with `up` upwards in its image.
Rigid3 LookAlong(const Vector3d& position, const Vector3d& forward, const Vector3d& up) {
  Eigen::Matrix3d axes;
  axes.col(2) = forward.normalized();
  axes.col(0) = forward.cross(up).normalized();
  axes.col(1) = axes.col(2).cross(axes.col(0));
  return {Eigen::Quaterniond(axes).normalized(), position};
}

// Places from `low` to `high` with both ends, at most `step` apart.
std::vector<double> Stations(double low, double high, double step) {
  const double most = std::ceil((high - low) / step);
  if (!(most >= 0.0 && most < kMostImages)) throw UsageError("the flight has too many images");
  const int count = std::max(static_cast<int>(most), 1);
  std::vector<double> stations;
  for (int i = 0; i <= count; ++i) stations.push_back(low + (high - low) * i / count);
  return stations;
}

// Back and forth along y, looking down and somewhat ahead, with the image's upper edge ahead.
std::vector<Rigid3> Lines(const Vector2d& low, const Vector2d& high, const FlightOptions& o) {
  const double across = o.height / o.camera.focal;
  const double along = across * o.camera.height / o.camera.width;
  const auto columns = Stations(low.x(), high.x(), across * (1.0 - o.overlap_across));
  const auto rows = Stations(low.y(), high.y(), along * (1.0 - o.overlap_along));
  if (columns.size() * rows.size() > kMostImages) {
    throw UsageError("the flight has too many images");
  }
  std::vector<Rigid3> poses;
  double ahead = 1.0;
  const double sine = std::sin(o.line_pitch), cosine = std::cos(o.line_pitch);
  for (const double x : columns) {
    for (std::size_t k = 0; k < rows.size(); ++k) {
      const double y = ahead > 0.0 ? rows[k] : rows[rows.size() - 1 - k];
      poses.push_back(
          LookAlong({x, y, o.height}, {0.0, ahead * sine, -cosine}, {0.0, ahead * cosine, sine}));
    }
    ahead = -ahead;
  }
  return poses;
}

// An ellipse.
std::vector<Rigid3> Ring(const Vector2d& middle, const Vector2d& radii, int images,
                         const FlightOptions& o) {
  const Vector3d target(middle.x(), middle.y(), o.target_height);
  std::vector<Rigid3> poses;
  for (int i = 0; i < images; ++i) {
    const double azimuth = 6.283185307179586 * i / images;
    const Vector3d position(middle.x() + radii.x() * std::cos(azimuth),
                            middle.y() + radii.y() * std::sin(azimuth), o.ring_height);
    poses.push_back(LookAlong(position, target - position, Vector3d::UnitZ()));
  }
  return poses;
}

Rigid3 Disturb(const Rigid3& pose, const FlightOptions& o, Random* random) {
  Vector3d shift, turn;
  for (int k = 0; k < 3; ++k) shift[k] = o.position_sigma * random->Normal();
  for (int k = 0; k < 3; ++k) turn[k] = o.tilt_sigma * random->Normal();
  return {(pose.rotation * ExpSO3(turn)).normalized(), pose.translation + shift};
}

}  // namespace

Vector3d PinholeCamera::Direction(const Vector2d& pixel) const {
  return {(pixel.x() - 0.5 * width) / FocalPixels(), (pixel.y() - 0.5 * height) / FocalPixels(),
          1.0};
}

std::optional<Vector2d> PinholeCamera::Project(const Vector3d& x_in_camera) const {
  if (!(x_in_camera.z() > 0.0)) return std::nullopt;
  const Vector2d pixel =
      FocalPixels() / x_in_camera.z() * x_in_camera.head<2>() + 0.5 * Vector2d(width, height);
  if (pixel.minCoeff() < 0.0 || pixel.x() > width || pixel.y() > height) return std::nullopt;
  return pixel;
}

Flight PlanFlight(const Vector2d& low, const Vector2d& high, const FlightOptions& options,
                  Random* random) {
  CheckOptions(options);
  Flight flight{options.camera, {}, Lines(low, high, options)};
  const Vector2d middle = 0.5 * (low + high), half = 0.5 * (high - low);
  const Vector2d margin = Vector2d::Constant(options.ring_margin);
  for (const auto& ring : {Ring(middle, half + margin, options.ring_images, options),
                           Ring(middle, 0.5 * half, options.inner_ring_images, options)}) {
    flight.world_from_camera.insert(flight.world_from_camera.end(), ring.begin(), ring.end());
  }
  double time = options.start_time;
  for (std::size_t k = 0; k < flight.world_from_camera.size(); ++k) {
    Rigid3& pose = flight.world_from_camera[k];
    pose = Disturb(pose, options, random);
    if (k > 0) {
      const Vector3d& last = flight.world_from_camera[k - 1].translation;
      time += std::max((pose.translation - last).norm() / options.speed, 0.1);
    }
    flight.times.push_back(time);
  }
  return flight;
}

}  // namespace planegraph
