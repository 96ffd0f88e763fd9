#pragma once

#include <vector>

#include "planegraph/geometry/sim3.h"

namespace planegraph {

/// A landmark as one node sees it, in the node's frame; nodes are scan poses and maps alike.
struct NodePlane {
  int node;
  Eigen::Vector3d normal, centroid;
  double tilt_sigma;    ///< radians
  double offset_sigma;  ///< metres of the world
};

struct NodeState {
  Sim3 world_from_node;
  bool fixed = false;
  bool has_scale = false;  ///< its scale is to be found
};

/// Rotations of all nodes that are not fixed, at once, from the normals of each landmark's planes:
/// minimizes sum |R_i n_ik - N_k|^2 / sigma^2 over 3x3 matrices R_i and vectors N_k, and projects
/// to SO(3). What the normals leave open stays as it is. O((3 nodes)^3) at worst, sparse.
void SolveRotationsJointly(const std::vector<std::vector<NodePlane>>& landmarks,
                           std::vector<NodeState>* nodes);

/// Translations (and scales) of all nodes that are not fixed, at once, the rotations as they are:
/// minimizes sum (N_k . (s_i R_i c_ik + t_i) - e_k)^2 / sigma^2 over t_i, s_i, e_k, N_k the mean
/// normal. What the planes leave open stays as it is.
void SolvePositionsJointly(const std::vector<std::vector<NodePlane>>& landmarks,
                           std::vector<NodeState>* nodes);

}  // namespace planegraph
