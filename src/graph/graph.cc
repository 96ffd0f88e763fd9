#include "planegraph/graph/graph.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <cmath>
#include <stdexcept>

#include "planegraph/geometry/rotation.h"
#include "planegraph/graph/manifolds.h"

namespace planegraph {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

double Weight(double variance) {
  return variance > 0.0 && std::isfinite(variance) ? 1.0 / std::sqrt(variance) : 0.0;
}

void Require(bool condition, const std::string& what) {
  if (!condition) throw std::invalid_argument(what);
}

void CheckPlane(const PlaneLandmark& plane, const Graph& graph, const std::string& name) {
  const int pose_count = static_cast<int>(graph.poses.size());
  const int map_count = static_cast<int>(graph.maps.size());
  Require(std::abs(plane.normal.norm() - 1.0) < 1e-6, name + ": normal is not of unit length");
  Require(std::isfinite(plane.offset) && plane.anchor.allFinite(), name + ": not finite");
  for (const PlaneObservation& seen : plane.observations) {
    Require(seen.map < map_count, name + ": observation without its map");
    Require(seen.map >= 0 || (seen.pose >= 0 && seen.pose < pose_count),
            name + ": observation without its pose");
    Require(seen.centroid.allFinite() && seen.axes.allFinite(), name + ": not finite");
    Require(std::isfinite(seen.tilt_weight_1 + seen.tilt_weight_2 + seen.offset_weight),
            name + ": weights are not finite");
  }
}

void CheckPlaneFactor(const PlaneFactor& factor, int plane_count, const std::string& name) {
  for (const int plane : factor.planes) {
    Require(plane >= 0 && plane < plane_count, name + ": names a plane that does not exist");
  }
  Require(factor.planes[0] != factor.planes[1], name + ": ties a plane to itself");
  Require(factor.sigma_angle > 0.0 && factor.sigma_offset > 0.0,
          name + ": a sigma is not positive");
}

void CheckPoseFactor(const PoseFactor& factor, const Graph& graph, const std::string& name) {
  const int pose_count = static_cast<int>(graph.poses.size());
  Require(!factor.poses.empty() || factor.scale >= 0, name + ": no poses");
  Require(factor.scale < static_cast<int>(graph.scales.size()),
          name + ": names a scale that does not exist");
  for (int pose : factor.poses) {
    Require(pose >= 0 && pose < pose_count, name + ": names a pose that does not exist");
  }
  Require(factor.poses.size() < 2 || factor.poses[0] != factor.poses[1],
          name + ": ties a pose to itself");
  Require(factor.information.allFinite(), name + ": information is not finite");
  Require(factor.point.allFinite() && factor.measurement.translation.allFinite(),
          name + ": not finite");
}

void CheckMapFactor(const MapFactor& factor, int map_count, const std::string& name) {
  Require(factor.maps.size() == 1 || factor.maps.size() == 2, name + ": needs one map or two");
  for (int map : factor.maps) {
    Require(map >= 0 && map < map_count, name + ": names a map that does not exist");
  }
  Require(factor.maps.size() < 2 || factor.maps[0] != factor.maps[1],
          name + ": ties a map to itself");
  Require(factor.point.allFinite() && factor.position.allFinite(), name + ": not finite");
  Require(factor.information.allFinite(), name + ": information is not finite");
}

// Normal equations of one observation for the tangent (tilt 1, tilt 2, offset) of a plane.
void AddNormalEquations(const Sim3& world_from_node, const PlaneObservation& seen,
                        const PlaneLandmark& plane, const Eigen::Matrix<double, 3, 2>& basis,
                        Matrix3d* h, Vector3d* g) {
  const Matrix3d rotation = world_from_node.rotation.toRotationMatrix();
  const Vector3d arm = world_from_node * seen.centroid - plane.anchor;
  Matrix3d rows;  // d residual / d normal
  rows.row(0) = seen.tilt_weight_1 * (rotation * seen.axes.col(1)).transpose();
  rows.row(1) = seen.tilt_weight_2 * (rotation * seen.axes.col(2)).transpose();
  rows.row(2) = seen.offset_weight * arm.transpose();
  const Vector3d residual =
      rows * plane.normal - Vector3d(0.0, 0.0, seen.offset_weight * plane.offset);
  Matrix3d jacobian;
  jacobian.leftCols<2>() = rows * basis;
  jacobian.col(2) << 0.0, 0.0, -seen.offset_weight;
  *h += jacobian.transpose() * jacobian;
  *g += jacobian.transpose() * residual;
}

}  // namespace

PoseFactor MakeRelativePose(int target, int source, const Rigid3& target_from_source,
                            const Matrix6d& information, const std::string& measured_by) {
  PoseFactor factor;
  factor.poses = {target, source};
  factor.measurement = target_from_source;
  factor.information = information;
  factor.source = measured_by;
  return factor;
}

PoseFactor MakeScalePrior(int scale, double value, double sigma) {
  PoseFactor factor;
  factor.type = "scale_prior";
  factor.scale = scale;
  factor.point.x() = value;
  factor.information.setZero();
  factor.information(0, 0) = 1.0 / (sigma * sigma);
  return factor;
}

PoseFactor MakePosePrior(int pose, const Rigid3& world_from_node, const Matrix6d& information) {
  PoseFactor factor;
  factor.type = "pose_prior";
  factor.poses = {pose};
  factor.measurement = world_from_node;
  factor.information = information;
  factor.source = "prior";
  return factor;
}

PlaneObservation MakePlaneObservation(int pose, const PlaneSegment& segment) {
  PlaneObservation seen;
  seen.pose = pose;
  seen.centroid = segment.centroid();
  seen.axes = segment.axes.vectors;
  if (seen.axes.col(0).dot(segment.plane.normal) < 0.0) seen.axes.leftCols<2>() *= -1.0;
  seen.tilt_weight_1 = Weight(segment.covariance(0, 0));
  seen.tilt_weight_2 = Weight(segment.covariance(1, 1));
  seen.offset_weight = Weight(segment.covariance(2, 2));
  seen.point_count = segment.moments.count;
  seen.eigenvalues = segment.axes.values;
  seen.user_tag = segment.id;
  return seen;
}

PlaneLandmark MakePlaneLandmark(const Graph& graph, std::vector<PlaneObservation> observations) {
  Require(!observations.empty(), "a plane landmark needs an observation");
  PlaneLandmark plane;
  double total = 0.0;
  for (const PlaneObservation& seen : observations) {
    const double weight = std::max(seen.point_count, 1.0);
    plane.anchor += weight * (WorldFromObservation(graph, seen) * seen.centroid);
    total += weight;
  }
  plane.anchor /= total;
  const PlaneObservation& first = observations.front();
  const Sim3 world_from_node = WorldFromObservation(graph, first);
  plane.normal = (world_from_node.rotation * first.axes.col(0)).normalized();
  plane.offset = plane.normal.dot(world_from_node * first.centroid - plane.anchor);
  plane.observations = std::move(observations);
  return plane;
}

Sim3 WorldFromObservation(const Graph& graph, const PlaneObservation& seen) {
  if (seen.map >= 0) return graph.maps.at(seen.map).world_from_map;
  return Sim3(graph.poses.at(seen.pose).world_from_node);
}

void FitLandmark(const Graph& graph, PlaneLandmark* landmark) {
  constexpr int kMaxIterations = 20;
  for (int iteration = 0; iteration < kMaxIterations; ++iteration) {
    Matrix3d h = Matrix3d::Zero();
    Vector3d g = Vector3d::Zero();
    const auto basis = TangentBasis(landmark->normal);
    for (const PlaneObservation& seen : landmark->observations) {
      AddNormalEquations(WorldFromObservation(graph, seen), seen, *landmark, basis, &h, &g);
    }
    h.diagonal() *= 1.0 + 1e-12;  // keeps a plane with an unseen tilt solvable
    h.diagonal().array() += 1e-300;
    const Vector3d step = -h.ldlt().solve(g);
    if (!step.allFinite()) return;
    UnitVectorManifold().Plus(Vector3d(landmark->normal).data(), step.data(),
                              landmark->normal.data());
    landmark->offset += step[2];
    if (step.norm() < 1e-13) return;
  }
}

void CheckGraph(const Graph& graph) {
  for (const PoseNode& node : graph.poses) {
    const Rigid3& pose = node.world_from_node;
    Require(pose.translation.allFinite() && std::abs(pose.rotation.norm() - 1.0) < 1e-6,
            "pose " + node.id + ": not a rigid motion");
  }
  for (std::size_t k = 0; k < graph.planes.size(); ++k) {
    CheckPlane(graph.planes[k], graph, "plane " + std::to_string(k));
  }
  for (std::size_t k = 0; k < graph.plane_factors.size(); ++k) {
    CheckPlaneFactor(graph.plane_factors[k], static_cast<int>(graph.planes.size()),
                     "plane factor " + std::to_string(k));
  }
  for (const MapNode& node : graph.maps) {
    const Sim3& map = node.world_from_map;
    Require(map.translation.allFinite() && std::abs(map.rotation.norm() - 1.0) < 1e-6 &&
                map.scale > 0.0 && std::isfinite(map.scale),
            "map " + node.id + ": not a similarity");
  }
  for (const ScaleNode& node : graph.scales) {
    Require(node.scale > 0.0 && std::isfinite(node.scale),
            "scale " + node.id + ": not a positive number");
  }
  for (std::size_t k = 0; k < graph.map_factors.size(); ++k) {
    CheckMapFactor(graph.map_factors[k], static_cast<int>(graph.maps.size()),
                   "map factor " + std::to_string(k));
  }
  for (std::size_t k = 0; k < graph.pose_factors.size(); ++k) {
    CheckPoseFactor(graph.pose_factors[k], graph, "pose factor " + std::to_string(k));
  }
}

Matrix6d SquareRootInformation(const Matrix6d& information) {
  // Judge the rank after scaling to unit diagonal: metres and radians have different magnitudes.
  const Vector6d diagonal = information.diagonal();
  Require(diagonal.minCoeff() >= 0.0, "information matrix with a negative diagonal");
  const Vector6d scale = diagonal.cwiseSqrt();
  const Vector6d inverse = (scale.array() > 0.0).select(scale.cwiseMax(1e-300).cwiseInverse(), 0.0);
  const Matrix6d symmetric = 0.5 * (information + information.transpose());
  const Eigen::SelfAdjointEigenSolver<Matrix6d> solver(inverse.asDiagonal() * symmetric *
                                                       inverse.asDiagonal());
  Require(solver.eigenvalues().minCoeff() > -1e-6, "information matrix is not positive");
  const Vector6d values =
      (solver.eigenvalues().array() > 1e-12).select(solver.eigenvalues().cwiseMax(0.0), 0.0);
  return values.cwiseSqrt().asDiagonal() * solver.eigenvectors().transpose() * scale.asDiagonal();
}

}  // namespace planegraph
