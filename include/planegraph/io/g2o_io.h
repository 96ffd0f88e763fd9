#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <map>
#include <string>
#include <vector>

#include "planegraph/geometry/rigid3.h"
#include "planegraph/io/trajectory_io.h"

namespace planegraph {

/// A planar pose: x, y in metres, angle in radians (as in the file, not wrapped).
struct Pose2 {
  double x = 0.0, y = 0.0, angle = 0.0;
};

using Matrix6d = Eigen::Matrix<double, 6, 6>;

/// VERTEX_SE3:QUAT: world_from_body, the quaternion normalized.
struct G2oVertex3 {
  long long id = 0;
  Rigid3 pose;
};
/// VERTEX_SE2.
struct G2oVertex2 {
  long long id = 0;
  Pose2 pose;
};
/// EDGE_SE3:QUAT: the measured from_from_to. `information` is as in the file: order x y z qx qy qz,
/// of g2o's error, whose rotation part is the vector part of the error's quaternion (half the
/// angle).
struct G2oEdge3 {
  long long from = 0, to = 0;
  Rigid3 measurement;
  Matrix6d information = Matrix6d::Identity();
};
/// EDGE_SE2; information in the order x y angle.
struct G2oEdge2 {
  long long from = 0, to = 0;
  Pose2 measurement;
  Eigen::Matrix3d information = Eigen::Matrix3d::Identity();
};

/// EDGE_SE3_PRIOR: the measured world_from_body; information as in G2oEdge3.
struct G2oPrior3 {
  long long id = 0;
  Rigid3 measurement;
  Matrix6d information = Matrix6d::Identity();
};
/// EDGE_PRIOR_SE2.
struct G2oPrior2 {
  long long id = 0;
  Pose2 measurement;
  Eigen::Matrix3d information = Eigen::Matrix3d::Identity();
};

/// What a g2o file says, each list in the file's order.
struct G2oGraph {
  std::vector<G2oVertex3> vertices3;
  std::vector<G2oVertex2> vertices2;
  std::vector<G2oEdge3> edges3;
  std::vector<G2oEdge2> edges2;
  std::vector<G2oPrior3> priors3;
  std::vector<G2oPrior2> priors2;
  std::vector<long long> fixed;                ///< ids of FIX lines
  std::map<std::string, std::size_t> unknown;  ///< lines of each tag that was passed over
};

/// Reads a g2o file. Unknown tags are counted in `unknown`. InputError, with the line: a malformed
/// line of a known tag, a vertex that occurs twice, an edge to none, a prior with a sensor offset
/// that is not the identity; and a file without any vertex.
G2oGraph ReadG2o(const std::string& path);

/// Writes vertices (3-D, then planar), FIX lines, priors and edges, each in order, every number in
/// the shortest form that reads back the same, atomically. `unknown` is not written.
void WriteG2o(const std::string& path, const G2oGraph& graph);

/// The vertices in the file's order as a trajectory without times (planar ones at z = 0); the
/// "times" are the vertices' ids.
Trajectory TrajectoryOf(const G2oGraph& graph);

}  // namespace planegraph
