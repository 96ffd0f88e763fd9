#include "simulation/depth_views.h"

#include <algorithm>
#include <cmath>

#include "planegraph/geometry/rotation.h"
#include "simulation/streams.h"

namespace planegraph {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

// The `count` nearest of the other images that are used, the farthest of them first.
std::vector<int> Neighbours(const Flight& flight, const std::vector<bool>& used, int view,
                            int count) {
  const auto distance = [&](int other) {
    return (flight.world_from_camera[other].translation -
            flight.world_from_camera[view].translation)
        .norm();
  };
  std::vector<int> others;
  for (int i = 0; i < static_cast<int>(used.size()); ++i) {
    if (i != view && used[i]) others.push_back(i);
  }
  std::stable_sort(others.begin(), others.end(),
                   [&](int a, int b) { return distance(a) < distance(b); });
  others.resize(std::min<std::size_t>(others.size(), count));
  std::reverse(others.begin(), others.end());
  return others;
}

Vector3d Turned(const Vector3d& direction, double sigma, Random* random) {
  Vector3d turn;
  for (int k = 0; k < 3; ++k) turn[k] = sigma * random->Normal();
  return ExpSO3(turn) * direction;
}

}  // namespace

DepthViews::DepthViews(const RayCaster& caster, const Flight& flight,
                       const PhotogrammetryOptions& options, const std::vector<bool>& used,
                       std::uint64_t seed)
    : caster_(caster),
      flight_(flight),
      options_(options),
      seed_(seed),
      look_(options, seed),
      surface_error_(seed ^ 0x5f, options.correlation_length),
      neighbours_(used.size()) {
  for (int i = 0; i < static_cast<int>(used.size()); ++i) {
    if (used[i]) neighbours_[i] = Neighbours(flight, used, i, options.neighbours);
  }
}

DepthViews::Pixel DepthViews::Look(int view, const Vector2d& pixel) const {
  const Rigid3& world_from_camera = flight_.world_from_camera[view];
  Pixel result;
  result.ray = flight_.camera.Direction(pixel);
  const Vector3d direction = world_from_camera.rotation * result.ray.normalized();
  result.hit = caster_.Cast(world_from_camera.translation, direction, options_.max_range);
  if (result.hit) result.depth = result.hit->distance / result.ray.norm();
  return result;
}

// One pixel at random from each square.
DepthViews::Grid DepthViews::LookAtGrid(int view, Random* random) const {
  const double step = options_.pixel_step;
  Grid grid;
  grid.columns = flight_.camera.width / options_.pixel_step;
  grid.rows = flight_.camera.height / options_.pixel_step;
  for (int row = 0; row < grid.rows; ++row) {
    for (int column = 0; column < grid.columns; ++column) {
      const double u = step * (column + random->Uniform());
      const double v = step * (row + random->Uniform());
      grid.pixels.push_back(Look(view, {u, v}));
    }
  }
  return grid;
}

// Whether the pixels around show another plane, so that a matching window may reach into it.
bool DepthViews::IsAtEdge(const Grid& grid, int column, int row) const {
  const int label = grid.pixels[row * grid.columns + column].hit->label;
  if (label == kNotPlanar) return true;
  for (int r = std::max(row - 1, 0); r <= std::min(row + 1, grid.rows - 1); ++r) {
    for (int c = std::max(column - 1, 0); c <= std::min(column + 1, grid.columns - 1); ++c) {
      const auto& hit = grid.pixels[r * grid.columns + c].hit;
      if (!hit || hit->label != label) return true;
    }
  }
  return false;
}

bool DepthViews::Sees(int view, const Vector3d& point) const {
  constexpr double kTolerance = 0.01;
  const Vector3d& origin = flight_.world_from_camera[view].translation;
  const Vector3d to_point = point - origin;
  const double distance = to_point.norm();
  const auto hit = caster_.Cast(origin, to_point / distance, options_.max_range);
  return hit && std::abs(hit->distance - distance) < kTolerance &&
         hit->cosine > options_.min_cosine;
}

// Across the ray, metres.
std::optional<double> DepthViews::Baseline(int view, const Pixel& pixel,
                                           const Vector3d& point) const {
  const Vector3d to_view = (flight_.world_from_camera[view].translation - point).normalized();
  const double least_cosine = std::cos(options_.max_angle);
  for (const int other : neighbours_[view]) {
    const Rigid3& world_from_other = flight_.world_from_camera[other];
    const Vector3d to_other = world_from_other.translation - point;
    const double cosine = to_other.normalized().dot(to_view);
    if (cosine < least_cosine || pixel.hit->normal.dot(to_other) <= 0.0) continue;
    if (!flight_.camera.Project(world_from_other.rotation.conjugate() * -to_other)) continue;
    if (Sees(other, point))
      return to_other.norm() * std::sqrt(std::max(1.0 - cosine * cosine, 0.0));
  }
  return std::nullopt;
}

// The inverse depth is linear in the image of a plane: its mean over two opposite pixels changes
// nothing there. None: lost at a jump.
std::optional<double> DepthViews::SmoothedDepth(int view, const Pixel& pixel,
                                                Random* random) const {
  const double azimuth = random->Uniform(0.0, 6.283185307179586);
  const Vector2d offset =
      random->Uniform(0.0, options_.window) * Vector2d(std::cos(azimuth), std::sin(azimuth));
  const bool lost_at_jump = random->Chance(0.5);
  const double focal = flight_.camera.FocalPixels();
  const Vector2d middle =
      focal * pixel.ray.head<2>() + 0.5 * Vector2d(flight_.camera.width, flight_.camera.height);
  double mean = 0.0;
  for (const double sign : {-1.0, 1.0}) {
    const Pixel beside = Look(view, middle + sign * offset);
    const bool jump = !beside.hit || std::abs(beside.depth - pixel.depth) > options_.edge_gap;
    if (jump && lost_at_jump) return std::nullopt;
    if (jump) return pixel.depth;
    mean += 0.5 / beside.depth;
  }
  return 1.0 / ((1.0 - options_.smoothing) / pixel.depth + options_.smoothing * mean);
}

// Of the depth, metres.
double DepthViews::DepthError(int view, const Vector3d& point, double sigma, Random* random) const {
  const SmoothField image_error(seed_ * 0x9e3779b97f4a7c15ULL + static_cast<std::uint64_t>(view),
                                options_.correlation_length);
  const double white = 1.0 - options_.surface_share - options_.image_share;
  double error = sigma * (std::sqrt(options_.surface_share) * surface_error_(point) +
                          std::sqrt(options_.image_share) * image_error(point) +
                          std::sqrt(std::max(white, 0.0)) * random->Normal());
  const bool outlier = random->Chance(options_.outlier_share);
  const double jump = options_.outlier_sigma * random->Normal();
  if (outlier) error += jump;
  return error;
}

std::optional<DepthPoint> DepthViews::MeasurePixel(int view, const Pixel& pixel, bool at_edge,
                                                   Random* random) const {
  constexpr double kBlurred = 0.02;  // metres off its plane
  const Rigid3& world_from_camera = flight_.world_from_camera[view];
  const Vector3d point = world_from_camera * (pixel.depth * pixel.ray);
  if (pixel.hit->cosine <= options_.min_cosine) return std::nullopt;
  if (!random->Chance(look_.KeptShare(*pixel.hit, point))) return std::nullopt;
  const auto baseline = Baseline(view, pixel, point);
  if (!baseline) return std::nullopt;
  const double focal = flight_.camera.FocalPixels();
  const double sigma = pixel.depth * pixel.depth * options_.disparity_sigma / (focal * *baseline);
  if (!(sigma <= options_.max_sigma)) return std::nullopt;
  const auto smoothed =
      at_edge ? SmoothedDepth(view, pixel, random) : std::optional<double>(pixel.depth);
  if (!smoothed) return std::nullopt;
  const double depth = *smoothed + DepthError(view, point, sigma, random);
  if (depth <= 0.0) return std::nullopt;
  DepthPoint result;
  result.position = world_from_camera * (depth * pixel.ray);
  result.normal = Turned(pixel.hit->normal, options_.normal_sigma, random);
  result.sigma = sigma * pixel.ray.norm();
  result.spacing = options_.pixel_step * pixel.depth / focal;
  const double off_plane = std::abs(*smoothed - pixel.depth) * pixel.ray.norm() * pixel.hit->cosine;
  result.label = off_plane > kBlurred ? kNotPlanar : pixel.hit->label;
  result.view = view;
  result.color = look_.Color(*pixel.hit, point);
  return result;
}

std::vector<DepthPoint> DepthViews::Measure(int view) const {
  std::vector<DepthPoint> points;
  if (neighbours_[view].empty()) return points;
  Random random(seed_, kFirstViewStream + static_cast<std::uint64_t>(view));
  const Grid grid = LookAtGrid(view, &random);
  for (int row = 0; row < grid.rows; ++row) {
    for (int column = 0; column < grid.columns; ++column) {
      const Pixel& pixel = grid.pixels[row * grid.columns + column];
      if (!pixel.hit) continue;
      const bool smooth = options_.smoothing > 0.0 && IsAtEdge(grid, column, row);
      const auto point = MeasurePixel(view, pixel, smooth, &random);
      if (point) points.push_back(*point);
    }
  }
  return points;
}

}  // namespace planegraph
