#pragma once

// Graphs of which nothing is known but, and that in part wrongly, which observations belong
// together.
#include <random>
#include <utility>
#include <vector>

#include "planegraph/graph/graph.h"

namespace planegraph {

/// Any rotation and any place within some `spread` metres, for all poses that are not fixed.
inline void ScatterPoses(double spread, std::mt19937_64* rng, Graph* graph) {
  std::normal_distribution<double> normal;
  for (PoseNode& node : graph->poses) {
    if (node.fixed) continue;
    const Eigen::Vector4d q(normal(*rng), normal(*rng), normal(*rng), normal(*rng));
    const Eigen::Vector3d t(normal(*rng), normal(*rng), normal(*rng));
    node.world_from_node = {Eigen::Quaterniond(q.normalized()), spread * t};
  }
}

/// A share of every pose's observations changes places among themselves.
inline void MismatchObservations(double share, std::mt19937_64* rng, Graph* graph) {
  std::uniform_real_distribution<double> uniform;
  for (int pose = 0; pose < static_cast<int>(graph->poses.size()); ++pose) {
    std::vector<PlaneObservation*> wrong;
    for (PlaneLandmark& plane : graph->planes) {
      for (PlaneObservation& seen : plane.observations) {
        if (seen.pose == pose && uniform(*rng) < share) wrong.push_back(&seen);
      }
    }
    for (std::size_t i = wrong.size(); i > 1; --i) std::swap(*wrong[i - 1], *wrong[(*rng)() % i]);
  }
}

}  // namespace planegraph
