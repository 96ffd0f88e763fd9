#pragma once

// A random world of planes seen by random poses, with exact truth: for the tests of the solver.
#include <cmath>
#include <random>

#include "planegraph/geometry/rotation.h"
#include "planegraph/graph/graph.h"

namespace planegraph {

struct PlaneWorldOptions {
  int poses = 6;
  int planes = 40;
  double seen_share = 0.6;  ///< of the planes by a pose
  int directions = 0;       ///< 0: any normal; 1, 2, 3: normals along that many axes
  double noise = 0.0;       ///< 1: observations with noise of the stated covariance
  std::uint64_t seed = 1;
};

class PlaneWorld {
 public:
  explicit PlaneWorld(const PlaneWorldOptions& options) : options_(options), rng_(options.seed) {
    for (int i = 0; i < options.poses; ++i) {
      const Eigen::Vector3d t(3.0 * i, Normal(), 0.3 * Normal());
      truth_.poses.push_back({std::to_string(i), Rigid3(ExpSO3(0.8 * Vector()), t), i == 0});
    }
    for (int k = 0; k < options.planes; ++k) AddPlane(k);
  }

  const Graph& truth() const { return truth_; }
  std::mt19937_64& rng() { return rng_; }
  double Normal() { return normal_(rng_); }
  Eigen::Vector3d Vector() { return {Normal(), Normal(), Normal()}; }

  /// The truth with disturbed poses (the fixed ones stay) and planes.
  Graph Disturbed(double translation, double rotation) {
    Graph graph = truth_;
    for (PoseNode& node : graph.poses) {
      if (node.fixed) continue;
      node.world_from_node.translation += translation * Vector();
      node.world_from_node.rotation =
          (ExpSO3(rotation * Vector()) * node.world_from_node.rotation).normalized();
    }
    for (PlaneLandmark& plane : graph.planes) {
      plane.normal = (plane.normal + rotation * Vector()).normalized();
      plane.offset += translation * Normal();
    }
    return graph;
  }

 private:
  Eigen::Vector3d PlaneNormal(int k) {
    if (options_.directions == 0) return Vector().normalized();
    return (k % 2 == 0 ? 1.0 : -1.0) * Eigen::Vector3d::Unit(k % options_.directions);
  }

  void AddPlane(int k) {
    PlaneLandmark plane;
    plane.anchor = Eigen::Vector3d(1.5 * options_.poses, 0, 0) + 8.0 * Vector();
    plane.normal = PlaneNormal(k);
    plane.user_tag = k;
    for (int i = 0; i < options_.poses; ++i) {
      if (std::uniform_real_distribution<double>()(rng_) < options_.seen_share) {
        plane.observations.push_back(Observe(plane, i));
      }
    }
    if (!plane.observations.empty()) truth_.planes.push_back(plane);
  }

  PlaneObservation Observe(const PlaneLandmark& plane, int pose) {
    const Rigid3 node_from_world = truth_.poses[pose].world_from_node.Inverse();
    PlaneObservation seen;
    seen.pose = pose;
    seen.tilt_weight_1 = 200.0 + 100.0 * std::abs(Normal());
    seen.tilt_weight_2 = 400.0 + 100.0 * std::abs(Normal());
    seen.offset_weight = 100.0 + 50.0 * std::abs(Normal());
    const auto basis = TangentBasis(plane.normal);
    const Eigen::Vector3d in_plane = basis * Eigen::Vector2d(Normal(), Normal());
    const double offset_error = options_.noise * Normal() / seen.offset_weight;
    seen.centroid =
        node_from_world * (plane.anchor + (plane.offset + offset_error) * plane.normal + in_plane);
    const double turn = 3.0 * Normal();
    const Eigen::Vector3d v1 = basis * Eigen::Vector2d(std::cos(turn), std::sin(turn));
    const Eigen::Vector3d v2 = plane.normal.cross(v1);
    const Eigen::Vector3d tilt =
        options_.noise * (Normal() / seen.tilt_weight_1 * v1 + Normal() / seen.tilt_weight_2 * v2);
    const Eigen::Matrix3d turned = ExpSO3(plane.normal.cross(tilt)).toRotationMatrix();
    Eigen::Matrix3d axes;
    axes << plane.normal, v1, v2;
    seen.axes = node_from_world.rotation.toRotationMatrix() * turned * axes;
    seen.point_count = 100;
    return seen;
  }

  PlaneWorldOptions options_;
  std::mt19937_64 rng_;
  std::normal_distribution<double> normal_;
  Graph truth_;
};

/// Largest difference of positions (metres) and of rotations (radians).
inline double LargestPoseDifference(const Graph& a, const Graph& b) {
  double largest = 0.0;
  for (std::size_t i = 0; i < a.poses.size(); ++i) {
    const Rigid3 &x = a.poses[i].world_from_node, &y = b.poses[i].world_from_node;
    largest = std::max(
        {largest, (x.translation - y.translation).norm(), AngleBetween(x.rotation, y.rotation)});
  }
  return largest;
}

inline Matrix6d OdometryInformation(double sigma_translation, double sigma_rotation) {
  Vector6d sigmas;
  sigmas << Eigen::Vector3d::Constant(sigma_translation), Eigen::Vector3d::Constant(sigma_rotation);
  return sigmas.cwiseProduct(sigmas).cwiseInverse().asDiagonal();
}

/// The true steps between successive poses as factors of these standard deviations (metres,
/// radians).
inline void AddOdometry(double sigma_translation, double sigma_rotation, Graph* graph) {
  for (int i = 0; i + 1 < static_cast<int>(graph->poses.size()); ++i) {
    const Rigid3 step =
        graph->poses[i].world_from_node.Inverse() * graph->poses[i + 1].world_from_node;
    graph->pose_factors.push_back(MakeRelativePose(
        i, i + 1, step, OdometryInformation(sigma_translation, sigma_rotation), "odometry"));
  }
}

}  // namespace planegraph
