// A room of six walls, seen from three poses: graph, solve, covariance and robust losses by the C++
// API alone. Each claim of the comments is checked; the program fails where one does not hold.
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <random>
#include <vector>

#include "planegraph/geometry/rotation.h"
#include "planegraph/solve/covariance.h"
#include "planegraph/solve/solver.h"

namespace {

using namespace planegraph;
using Eigen::Vector3d;

constexpr double kTilt = 0.002, kOffset = 0.005;          // sigmas of an observation: rad, m
constexpr double kOdometry = 0.05, kOdometryTurn = 0.02;  // of a step: m, rad

std::mt19937_64 rng(1);
double Normal(double sigma) { return std::normal_distribution<double>(0.0, sigma)(rng); }

void Check(bool holds, const char* claim) {
  std::printf("%s: %s\n", holds ? "holds" : "DOES NOT HOLD", claim);
  if (!holds) std::exit(1);
}

// A wall of the world: a point on it, and its normal, into the room.
struct Wall {
  Vector3d centre, normal;
};

// What a pose sees of a wall. All of it is in the pose's frame: the centroid of the points, their
// principal axes (normal first), and square roots of information for two tilts and the offset. With
// clouds in hand, MakePlaneObservation takes a segment of the segmentation instead.
PlaneObservation Observe(const Rigid3& world_from_scan, int pose, const Wall& wall) {
  const Rigid3 scan_from_world = world_from_scan.Inverse();
  PlaneObservation seen;
  seen.pose = pose;
  seen.axes.col(0) = scan_from_world.rotation * wall.normal;
  seen.axes.rightCols<2>() = TangentBasis(seen.axes.col(0));
  const Vector3d tilt = seen.axes.col(1) * Normal(kTilt) + seen.axes.col(2) * Normal(kTilt);
  seen.axes = ExpSO3(tilt).toRotationMatrix() * seen.axes;
  seen.centroid = scan_from_world * wall.centre + seen.axes.col(0) * Normal(kOffset);
  seen.tilt_weight_1 = seen.tilt_weight_2 = 1.0 / kTilt;
  seen.offset_weight = 1.0 / kOffset;
  return seen;
}

struct Room {
  std::vector<Wall> walls = {{{0, 3, 1}, {1, 0, 0}}, {{8, 3, 1}, {-1, 0, 0}},
                             {{4, 0, 1}, {0, 1, 0}}, {{4, 6, 1}, {0, -1, 0}},
                             {{4, 3, 0}, {0, 0, 1}}, {{4, 3, 3}, {0, 0, -1}}};
  std::vector<Rigid3> world_from_scan = {{Eigen::Quaterniond::Identity(), {2, 2, 1}},
                                         {ExpSO3({0, 0, 0.6}), {4, 2.5, 1}},
                                         {ExpSO3({0, 0, 1.4}), {5.5, 4, 1}}};
};

// Poses, what odometry says between them, and one landmark for each wall.
Graph BuildGraph(const Room& room) {
  Graph graph;
  Vector6d sigma;
  sigma << Vector3d::Constant(kOdometry), Vector3d::Constant(kOdometryTurn);
  const Matrix6d information = sigma.cwiseAbs2().cwiseInverse().asDiagonal();
  for (int i = 0; i < 3; ++i) {
    const Rigid3& truth = room.world_from_scan[i];
    if (i == 0) {
      graph.poses.push_back({"scan0", truth, true});  // the gauge: it stays where it is
      continue;
    }
    Rigid3 step = room.world_from_scan[i - 1].Inverse() * truth;
    step.translation += Vector3d(Normal(kOdometry), Normal(kOdometry), Normal(kOdometry));
    step.rotation = ExpSO3({0, 0, Normal(kOdometryTurn)}) * step.rotation;
    // target_from_source with its information, order x y z rx ry rz, in the target's axes.
    PoseFactor odometry = MakeRelativePose(i - 1, i, step, information, "odometry");
    odometry.robust = true;  // it takes a loss
    graph.pose_factors.push_back(odometry);
    graph.poses.push_back(
        {"scan" + std::to_string(i), graph.poses[i - 1].world_from_node * step, false});
  }
  for (const Wall& wall : room.walls) {
    std::vector<PlaneObservation> seen;
    for (int i = 0; i < 3; ++i) seen.push_back(Observe(room.world_from_scan[i], i, wall));
    graph.planes.push_back(MakePlaneLandmark(graph, seen));
  }
  return graph;
}

// How far a pose is from the truth, metres.
double Error(const Graph& graph, const Room& room, int pose) {
  return (graph.poses[pose].world_from_node.translation - room.world_from_scan[pose].translation)
      .norm();
}

}  // namespace

int main() {
  const Room room;
  const Graph start = BuildGraph(room);

  // Least squares over poses and planes at once.
  Graph graph = start;
  const SolveSummary summary = Solve(&graph);
  Check(summary.converged, "the solve converges");
  const double reduced = 2.0 * summary.final_cost / summary.DegreesOfFreedom();
  Check(reduced > 0.3 && reduced < 2.5, "chi2 over its degrees of freedom is near 1");

  // Covariances of the solution: x y z rx ry rz, world's axes.
  const GraphCovariance covariance(graph);
  for (int i = 1; i < 3; ++i) {
    const double sigma = std::sqrt(covariance.Pose(i).topLeftCorner<3, 3>().trace());
    Check(Error(graph, room, i) < 4.0 * sigma, "the error is what the covariance says");
    Check(sigma < 0.5 * kOdometry, "the walls know the pose better than the odometry");
    Check(covariance.Unobserved(i).empty(), "the walls leave no direction open");
  }
  Check(covariance.Pose(0).isZero(), "the gauge has no covariance");

  // The third pose takes a cupboard, 0.7 m before the second wall, for the wall.
  Graph wrong = start;
  PlaneObservation& cupboard = wrong.planes[1].observations[2];
  cupboard.centroid += 0.7 * cupboard.axes.col(0);
  graph = wrong;
  Solve(&graph);
  Check(Error(graph, room, 2) > 0.1, "least squares follow a wrong correspondence");

  // A loss for the planes, and another one for the relative poses.
  SolveOptions options;
  options.plane_loss = ParseLoss("cauchy:2.4");
  options.factor_losses["relative_pose"] = ParseLoss("huber:2");
  graph = wrong;
  const SolveSummary robust = Solve(&graph, options);
  Check(Error(graph, room, 2) < 0.02, "a robust loss does not");
  for (const ResidualReport& residual : robust.residuals) {
    if (residual.tag.plane != 1 || residual.tag.observation != 2) continue;
    Check(residual.weight < 0.01, "the cupboard is off");
  }
  return 0;
}
