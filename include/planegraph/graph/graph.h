#pragma once

#include <Eigen/Core>
#include <array>
#include <memory>
#include <string>
#include <vector>

#include "planegraph/geometry/plane.h"
#include "planegraph/geometry/rigid3.h"
#include "planegraph/geometry/sim3.h"
#include "planegraph/segmentation/plane_segment.h"

namespace planegraph {

using Matrix6d = Eigen::Matrix<double, 6, 6>;
using Vector6d = Eigen::Matrix<double, 6, 1>;

/// A pose to be estimated.
struct PoseNode {
  std::string id;
  Rigid3 world_from_node;
  bool fixed = false;  ///< held by the gauge
};

/// A drone map (or a tile of one) to be placed: a rigid body of unknown scale.
struct MapNode {
  std::string id;
  Sim3 world_from_map;
  bool fixed = false;  ///< held by the gauge
  int user_tag = -1;   ///< the caller's: which drone map this is, or is a tile of
};

/// A scale that measurements have in common, say the metres that a metre of a robot's odometry is
/// (the radius of its wheels is never quite known). One parameter, about 1.
struct ScaleNode {
  std::string id;
  double scale = 1.0;
};

/// A plane segment seen from one pose, or in one map, reduced to what the factors need. All of it
/// in the node's frame.
struct PlaneObservation {
  int pose = 0;  ///< index in Graph::poses; without meaning where `map` is set
  int map = -1;  ///< index in Graph::maps; -1: seen from a pose. Weights are per metre of the world
  Eigen::Vector3d centroid = Eigen::Vector3d::Zero();
  /// Columns: the normal (MakePlaneObservation: the segment's; factors work with either sign), then
  /// the two in-plane axes.
  Eigen::Matrix3d axes = Eigen::Matrix3d::Identity();
  /// Square-root information: of the normal's tilt along axes 1 and 2 (1/rad), and of the offset at
  /// the centroid (1/m). Sensor noise, N_eff and systematic floors are already in.
  double tilt_weight_1 = 1.0, tilt_weight_2 = 1.0, offset_weight = 1.0;
  double point_count = 0.0;                               ///< points of the segment
  Eigen::Vector3d eigenvalues = Eigen::Vector3d::Zero();  ///< of their scatter, increasing, m^2
  int user_tag = -1;                                      ///< the caller's: segment, registration
  /// Observations of one group (>= 0) are right or wrong together, say those of one registration:
  /// graduated losses switch them as one, each truncated by itself first, so that a group stays
  /// while fewer than half of it are wrong, and these alone are off. -1: each by itself.
  int group = -1;
  /// The points themselves (node's frame), for the reference factor `raw_points` alone; mostly
  /// null.
  std::shared_ptr<const std::vector<Eigen::Vector3d>> points;
};

/// A plane of the world: normal . (p - anchor) = offset. The anchor is a constant near the plane;
/// it keeps the lever arms, and so the condition number, small far from the origin.
struct PlaneLandmark {
  Eigen::Vector3d anchor = Eigen::Vector3d::Zero();
  Eigen::Vector3d normal = Eigen::Vector3d::UnitZ();  ///< unit
  double offset = 0.0;                                ///< metres
  std::vector<PlaneObservation> observations;
  int user_tag = -1;

  Plane WorldPlane() const { return {normal, offset + normal.dot(anchor)}; }
};

/// A measurement between poses, or of one pose. What the fields mean is the business of its type
/// (see `planegraph factors`). For `relative_pose`: poses (target, source), measurement
/// target_from_source; for `pose_prior`: one pose, measurement world_from_node. For
/// `robot_position`: `point` is the antenna in the scan's frame, the measurement's translation
/// where it was; for `gravity`: `point` is the direction upwards in the scan's frame, the
/// measurement's translation that in the world. For `odometry_step`: as `relative_pose`, the
/// measured translation times Graph::scales[scale]. For `scale_prior`: no pose, the scale is
/// `point.x()` by an information of its own in the upper left.
struct PoseFactor {
  std::string type = "relative_pose";
  std::vector<int> poses;
  int scale = -1;  ///< index in Graph::scales; -1: none
  Rigid3 measurement;
  Eigen::Vector3d point = Eigen::Vector3d::Zero();
  /// 6x6, order x y z rx ry rz of the decoupled left perturbation in the target's (world's) axes,
  /// metres and radians. It may be rank-deficient.
  Matrix6d information = Matrix6d::Identity();
  std::string source = "odometry";  ///< who measured it: odometry, icp, prior, ...
  bool robust = false;              ///< takes SolveOptions::pose_loss
  int group = -1;                   ///< as PlaneObservation::group, among pose factors
  int user_tag = -1;
};

PoseFactor MakeRelativePose(int target, int source, const Rigid3& target_from_source,
                            const Matrix6d& information, const std::string& measured_by);
/// A `scale_prior` of the odometry.
PoseFactor MakeScalePrior(int scale, double value, double sigma);
PoseFactor MakePosePrior(int pose, const Rigid3& world_from_node, const Matrix6d& information);

/// A measurement of one map, or between two. For `camera_position`: the map and one of its cameras,
/// `point` (map frame) at `position` (world, metres) by GPS, `information` in its upper left 3x3
/// block. For `map_gravity`: `point` is the direction upwards in the map, `position` that in the
/// world. For `map_tie`: maps (target, source) with `measurement` target_from_source; `point`
/// (target's frame) is what both hold, say on their common border, `information` 7x7 in the order x
/// y z rx ry rz log(scale), metres of the world, target's axes.
struct MapFactor {
  std::string type = "camera_position";
  std::vector<int> maps;
  Eigen::Vector3d point = Eigen::Vector3d::Zero(), position = Eigen::Vector3d::Zero();
  Sim3 measurement;
  Matrix7d information = Matrix7d::Identity();
  std::string source = "gps";  ///< who measured it
  bool robust = false;         ///< takes SolveOptions::pose_loss
};

/// What is known of two landmarks: `parallel`, `perpendicular` or `coplanar`.
struct PlaneFactor {
  std::string type = "parallel";
  std::array<int, 2> planes = {0, 0};  ///< indices in Graph::planes
  double sigma_angle = 0.01;           ///< radians
  double sigma_offset = 0.01;          ///< metres, `coplanar` only
  std::string source = "constraint";   ///< who says so
  bool robust = false;                 ///< takes SolveOptions::plane_loss
};

/// Poses, drone maps, planes and what ties them.
struct Graph {
  std::vector<PoseNode> poses;
  std::vector<MapNode> maps;
  std::vector<ScaleNode> scales;
  std::vector<PlaneLandmark> planes;
  std::vector<PlaneFactor> plane_factors;
  std::vector<PoseFactor> pose_factors;
  std::vector<MapFactor> map_factors;
};

/// The similarity that takes an observation's frame to the world.
Sim3 WorldFromObservation(const Graph& graph, const PlaneObservation& seen);

/// The observation of a segment: weights from its covariance. Segments whose covariance is not
/// positive definite give zero weights in what is not known.
PlaneObservation MakePlaneObservation(int pose, const PlaneSegment& segment);

/// A landmark that starts from the first observation as its pose sees it, anchored at the mean of
/// the observations' centroids (weighted by their point counts). Needs at least one observation.
PlaneLandmark MakePlaneLandmark(const Graph& graph, std::vector<PlaneObservation> observations);

/// Moves normal and offset of a landmark to the least-squares plane of its observations under the
/// graph's poses and maps (the minimum of the moment factors over the plane alone).
void FitLandmark(const Graph& graph, PlaneLandmark* landmark);

/// Indices in range, unit normals and quaternions, finite numbers. Throws std::invalid_argument.
void CheckGraph(const Graph& graph);

/// L with L^T L = information; zero rows where the information has (numerically) none. Throws
/// std::invalid_argument for a matrix that is clearly not positive semi-definite.
Matrix6d SquareRootInformation(const Matrix6d& information);

}  // namespace planegraph
