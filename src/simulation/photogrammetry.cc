#include "planegraph/simulation/photogrammetry.h"

#include <algorithm>
#include <cmath>

#include "planegraph/base/error.h"
#include "planegraph/base/parallel.h"
#include "planegraph/geometry/rotation.h"
#include "simulation/depth_views.h"
#include "simulation/streams.h"

namespace planegraph {
namespace {

using Eigen::Vector3d;

void CheckOptions(const PhotogrammetryOptions& o) {
  constexpr int kLargestStep = 480;
  if (o.pixel_step < 1 || o.pixel_step > kLargestStep) {
    throw UsageError("pixel_step must lie in 1 to 480");
  }
  const auto share = [](double value) { return value >= 0.0 && value <= 1.0; };
  if (!share(o.surface_share) || !share(o.image_share) || o.surface_share + o.image_share > 1.0) {
    throw UsageError("the shares of the depth errors must lie in [0, 1], and so must their sum");
  }
  if (!(o.correlation_length > 0.0 && o.disparity_sigma >= 0.0 && o.max_range > 0.0)) {
    throw UsageError("depth errors need a correlation length > 0 and a sigma >= 0");
  }
  if (!(o.min_scale > 0.0 && o.max_scale >= o.min_scale && std::isfinite(o.max_scale))) {
    throw UsageError("the model's scale needs 0 < min_scale <= max_scale");
  }
  if (o.neighbours < 1) throw UsageError("stereo needs at least one neighbour");
}

Vector3d Normals(double sigma, Random* random) {
  Vector3d result;
  for (int k = 0; k < 3; ++k) result[k] = sigma * random->Normal();
  return result;
}

// Every direction of the frame equally likely (a normal vector of four dimensions, normalized).
Eigen::Quaterniond RandomRotation(Random* random) {
  Eigen::Vector4d coefficients;
  for (int k = 0; k < 4; ++k) coefficients[k] = random->Normal();
  return Eigen::Quaterniond(coefficients).normalized();
}

Sim3 RandomFrame(const PhotogrammetryOptions& options, Random* random) {
  constexpr double kShift = 30.0;
  const double scale = random->Uniform(options.min_scale, options.max_scale);
  const Eigen::Quaterniond rotation = RandomRotation(random);
  return {scale, rotation, Normals(kShift, random)};
}

// A paraboloid about the middle of the flight.
class Bowl {
 public:
  Bowl(const Flight& flight, double strength, Random* random) {
    for (const Rigid3& pose : flight.world_from_camera) {
      middle_ += pose.translation.head<2>() / static_cast<double>(flight.world_from_camera.size());
    }
    double radius = 1e-6;
    for (const Rigid3& pose : flight.world_from_camera) {
      radius = std::max(radius, (pose.translation.head<2>() - middle_).norm());
    }
    curvature_ = random->Sign() * random->Uniform(0.5, 1.5) * strength / radius;
    mean_ = 0.5 * curvature_ * radius * radius;
  }

  Vector3d Bend(const Vector3d& point) const {
    return {point.x(), point.y(),
            point.z() + curvature_ * (point.head<2>() - middle_).squaredNorm() - mean_};
  }
  /// How directions turn at a place.
  Eigen::Quaterniond Turn(const Vector3d& point) const {
    const Eigen::Vector2d slope = 2.0 * curvature_ * (point.head<2>() - middle_);
    return ExpSO3({slope.y(), -slope.x(), 0.0});
  }

 private:
  Eigen::Vector2d middle_ = Eigen::Vector2d::Zero();
  double curvature_ = 0.0, mean_ = 0.0;
};

// At least two stay in the model where the flight has two.
std::vector<bool> DrawRegistered(std::size_t count, double unregistered_share, Random* random) {
  std::vector<bool> registered(count);
  for (std::size_t k = 0; k < count; ++k) {
    registered[k] = !random->Chance(unregistered_share) || k < 2;
  }
  return registered;
}

void AddPoint(const DepthPoint& point, const Bowl& bowl, const Sim3& map_from_world,
              PhotogrammetryModel* model) {
  model->cloud.points.emplace_back((map_from_world * bowl.Bend(point.position)).cast<float>());
  const Vector3d normal = map_from_world.rotation * (bowl.Turn(point.position) * point.normal);
  model->cloud.normals.emplace_back(normal.cast<float>());
  model->cloud.colors.push_back(point.color);
  model->labels.push_back(point.label);
  model->views.push_back(point.view);
  model->sigmas.push_back(static_cast<float>(point.sigma));
  model->spacings.push_back(static_cast<float>(point.spacing * map_from_world.scale));
}

Rigid3 PlaceCamera(const Rigid3& truth, const Bowl& bowl, const Sim3& map_from_world,
                   const PhotogrammetryOptions& options, Random* random) {
  const Vector3d center = bowl.Bend(truth.translation) + Normals(options.position_sigma, random);
  const Eigen::Quaterniond turned = bowl.Turn(truth.translation) * truth.rotation *
                                    ExpSO3(Normals(options.rotation_sigma, random));
  return {(map_from_world.rotation * turned).normalized(), map_from_world * center};
}

}  // namespace

PhotogrammetryOptions PhotogrammetryOptions::WithoutNoise() const {
  PhotogrammetryOptions ideal = *this;
  ideal.disparity_sigma = ideal.smoothing = ideal.outlier_share = ideal.normal_sigma = 0.0;
  ideal.bowl = ideal.position_sigma = ideal.rotation_sigma = 0.0;
  return ideal;
}

PhotogrammetryModel Reconstruct(const RayCaster& caster, const Flight& flight,
                                const PhotogrammetryOptions& options, std::uint64_t seed,
                                int threads) {
  CheckOptions(options);
  Random random(seed, kModelStream);
  PhotogrammetryModel model;
  model.world_from_map = RandomFrame(options, &random);
  const Sim3 map_from_world = model.world_from_map.Inverse();
  const Bowl bowl(flight, options.bowl, &random);
  const std::size_t count = flight.world_from_camera.size();
  const auto registered = DrawRegistered(count, options.unregistered_share, &random);
  for (std::size_t k = 0; k < count; ++k) {
    const Rigid3 pose =
        PlaceCamera(flight.world_from_camera[k], bowl, map_from_world, options, &random);
    model.map_from_camera.push_back(registered[k] ? std::optional<Rigid3>(pose) : std::nullopt);
  }
  const DepthViews views(caster, flight, options, registered, seed);
  std::vector<std::vector<DepthPoint>> depths(count);
  ParallelFor(count, threads,
              [&](std::size_t k) { depths[k] = views.Measure(static_cast<int>(k)); });
  for (const auto& points : depths) {
    for (const DepthPoint& point : points) AddPoint(point, bowl, map_from_world, &model);
  }
  return model;
}

}  // namespace planegraph
