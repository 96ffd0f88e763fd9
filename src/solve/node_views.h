#pragma once

#include <vector>

#include "planegraph/graph/graph.h"
#include "solve/joint_linear.h"
#include "solve/pair_consensus.h"

namespace planegraph {

/// What the nodes of a graph see of its landmarks. Nodes are the poses, then the maps. Observations
/// that say nothing of tilt or offset take no part.
class NodeViews {
 public:
  struct View {
    NodePlane plane;
    int observation;  ///< index in the landmark
  };

  explicit NodeViews(const Graph& graph);

  bool IsMap(int node) const { return node >= pose_count_; }
  std::size_t LandmarkCount() const { return views_.size(); }
  const std::vector<View>& OfLandmark(std::size_t k) const { return views_[k]; }

  /// The largest set of a landmark's views, of one part, that agree with one of them, as indices in
  /// `views`; `part` by node.
  static std::vector<int> LargestSet(const std::vector<View>& views,
                                     const std::vector<NodeState>& nodes,
                                     const std::vector<int>& part, double gate_sigmas);

  /// The landmarks that two parts share, each in the frame that its part's nodes stand in.
  std::vector<SharedLandmark> SharedByParts(int target, int source,
                                            const std::vector<NodeState>& nodes,
                                            const std::vector<int>& part, double gate_sigmas) const;

 private:
  int pose_count_;
  std::vector<std::vector<View>> views_;  // by landmark
};

}  // namespace planegraph
