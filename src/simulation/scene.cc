#include "planegraph/simulation/scene.h"

#include <algorithm>
#include <cmath>

#include "planegraph/base/error.h"
#include "planegraph/geometry/rotation.h"
#include "simulation/scenes.h"
#include "simulation/streams.h"

namespace planegraph {
namespace {

double PathLength(const std::vector<Eigen::Vector2d>& path) {
  double length = 0.0;
  for (std::size_t i = 0; i + 1 < path.size(); ++i) length += (path[i + 1] - path[i]).norm();
  return length;
}

Eigen::Vector2d PointOnPath(const std::vector<Eigen::Vector2d>& path, double at) {
  for (std::size_t i = 0; i + 1 < path.size(); ++i) {
    const double length = (path[i + 1] - path[i]).norm();
    if (at <= length) return path[i] + std::max(at, 0.0) / length * (path[i + 1] - path[i]);
    at -= length;
  }
  return path.back();
}

double Clipped(double sigma, Random* random) {
  return sigma * std::clamp(random->Normal(), -3.0, 3.0);
}

Eigen::Vector3d GroundBelow(const RayCaster& caster, const Eigen::Vector2d& at, double height) {
  constexpr double kDeepest = 100.0;
  const Eigen::Vector3d origin(at.x(), at.y(), height);
  const auto hit = caster.Cast(origin, -Eigen::Vector3d::UnitZ(), kDeepest);
  if (!hit) throw NoResultError("the robot's path leaves the ground");
  return origin - hit->distance * Eigen::Vector3d::UnitZ();
}

// The frame of a robot that stands on four wheels: x ahead, z off the ground, origin on the ground.
Rigid3 StandOnGround(const Scene& scene, const RayCaster& caster, const Eigen::Vector2d& at,
                     double heading) {
  constexpr double kWheel = 0.3;
  const Eigen::Vector2d ahead(std::cos(heading), std::sin(heading));
  const Eigen::Vector2d left(-ahead.y(), ahead.x());
  const auto ground = [&](const Eigen::Vector2d& offset) {
    return GroundBelow(caster, at + kWheel * offset, scene.probe_height);
  };
  const Eigen::Vector3d front = ground(ahead), back = ground(-ahead);
  const Eigen::Vector3d port = ground(left), starboard = ground(-left);
  Eigen::Matrix3d axes;
  axes.col(0) = (front - back).normalized();
  axes.col(2) = (front - back).cross(port - starboard).normalized();
  axes.col(1) = axes.col(2).cross(axes.col(0));
  return {Eigen::Quaterniond(axes).normalized(), 0.25 * (front + back + port + starboard)};
}

Eigen::Quaterniond RandomTilt(const PoseOptions& options, Random* random) {
  double roll = Clipped(options.tilt_sigma, random), pitch = Clipped(options.tilt_sigma, random);
  const bool strong = random->Chance(options.strong_tilt_share);
  const double angle = random->Uniform(0.5, 1.0) * options.strong_tilt;
  const double azimuth = random->Uniform(0.0, 6.283185307179586);
  if (strong) {
    roll = angle * std::cos(azimuth);
    pitch = angle * std::sin(azimuth);
  }
  return ExpSO3({roll, pitch, 0.0});
}

}  // namespace

SceneKind ParseSceneKind(const std::string& name) {
  for (const auto kind :
       {SceneKind::kHall, SceneKind::kCorridor, SceneKind::kYard, SceneKind::kQuarter}) {
    if (name == SceneName(kind)) return kind;
  }
  throw UsageError("unknown scene '" + name + "' (hall, corridor, yard or quarter)");
}

std::string SceneName(SceneKind kind) {
  if (kind == SceneKind::kHall) return "hall";
  if (kind == SceneKind::kCorridor) return "corridor";
  return kind == SceneKind::kYard ? "yard" : "quarter";
}

Scene BuildScene(SceneKind kind, std::uint64_t seed, double max_range) {
  Random random(seed, kSceneStream);
  if (kind == SceneKind::kHall) return BuildHall(&random);
  if (kind == SceneKind::kCorridor) return BuildCorridor(&random, max_range);
  return kind == SceneKind::kYard ? BuildYard(&random) : BuildQuarter(&random);
}

std::vector<Rigid3> DrivePath(const Scene& scene, const RayCaster& caster, int count,
                              const PoseOptions& options, std::uint64_t seed, std::size_t drive) {
  Random random(seed, kDriveStream + kStreamsPerRobot * drive);
  const std::vector<Eigen::Vector2d>& path = scene.drives.at(drive).path;
  const double length = PathLength(path);
  std::vector<Rigid3> poses;
  for (int k = 0; k < count; ++k) {
    const double at = count > 1 ? length * k / (count - 1) : 0.0;
    // The robot cuts corners: its heading follows a chord of the path.
    const Eigen::Vector2d chord = PointOnPath(path, at + 0.7) - PointOnPath(path, at - 0.7);
    const double heading = std::atan2(chord.y(), chord.x());
    const Eigen::Vector2d left(-std::sin(heading), std::cos(heading));
    const Eigen::Vector2d position =
        PointOnPath(path, at) + Clipped(options.lateral_sigma, &random) * left;
    const double turned = heading + Clipped(options.heading_sigma, &random);
    const Rigid3 world_from_ground = StandOnGround(scene, caster, position, turned);
    const Eigen::Vector3d mount(0.0, 0.0, options.mount_height);
    poses.push_back(world_from_ground * Rigid3(RandomTilt(options, &random), mount));
  }
  return poses;
}

}  // namespace planegraph
