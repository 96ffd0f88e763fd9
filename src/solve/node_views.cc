#include "solve/node_views.h"

#include <cmath>
#include <optional>

namespace planegraph {
namespace {

using Eigen::Vector3d;
using View = NodeViews::View;

double TiltSigma(const PlaneObservation& seen) {
  return std::sqrt(0.5 * (std::pow(seen.tilt_weight_1, -2) + std::pow(seen.tilt_weight_2, -2)));
}

SharedLandmark Share(const NodePlane& target, const NodePlane& source) {
  return {target.normal,
          target.centroid,
          source.normal,
          source.centroid,
          std::hypot(target.tilt_sigma, source.tilt_sigma),
          std::hypot(target.offset_sigma, source.offset_sigma)};
}

bool Agree(const NodePlane& a, const NodePlane& b, const std::vector<NodeState>& nodes,
           double gate) {
  const Sim3 &pose_a = nodes[a.node].world_from_node, &pose_b = nodes[b.node].world_from_node;
  const Vector3d normal = pose_a.rotation * a.normal;
  const double tilt_sigma = std::hypot(a.tilt_sigma, b.tilt_sigma);
  if ((pose_b.rotation * b.normal - normal).norm() > gate * tilt_sigma) return false;
  const Vector3d apart = pose_b * b.centroid - pose_a * a.centroid;
  const double height = normal.dot(apart);
  const double lever = (apart - height * normal).norm();
  const double variance =
      std::pow(a.offset_sigma, 2) + std::pow(b.offset_sigma, 2) + std::pow(a.tilt_sigma * lever, 2);
  return std::abs(height) <= gate * std::sqrt(variance);
}

// A part's own view of a landmark: the mean of its planes that agree. Their errors hang together by
// the poses, so that the mean counts as no better than one of them.
std::optional<NodePlane> PartPlane(const std::vector<View>& views, int part,
                                   const std::vector<NodeState>& nodes,
                                   const std::vector<int>& parts, double gate) {
  std::vector<View> own;
  for (const View& view : views) {
    if (parts[view.plane.node] == part) own.push_back(view);
  }
  const std::vector<int> set = NodeViews::LargestSet(own, nodes, parts, gate);
  if (set.empty()) return {};
  NodePlane mean{part, Vector3d::Zero(), Vector3d::Zero(), 0.0, 0.0};
  const double share = 1.0 / static_cast<double>(set.size());
  for (int i : set) {
    const NodePlane& plane = own[i].plane;
    const Sim3& pose = nodes[plane.node].world_from_node;
    mean.normal += pose.rotation * plane.normal;
    mean.centroid += share * (pose * plane.centroid);
    mean.tilt_sigma += share * plane.tilt_sigma;
    mean.offset_sigma += share * plane.offset_sigma;
  }
  mean.normal.normalize();
  return mean;
}

}  // namespace

NodeViews::NodeViews(const Graph& graph) : pose_count_(static_cast<int>(graph.poses.size())) {
  for (const PlaneLandmark& landmark : graph.planes) {
    std::vector<View>& views = views_.emplace_back();
    for (std::size_t o = 0; o < landmark.observations.size(); ++o) {
      const PlaneObservation& seen = landmark.observations[o];
      if (!(seen.tilt_weight_1 > 0.0 && seen.tilt_weight_2 > 0.0 && seen.offset_weight > 0.0)) {
        continue;
      }
      const int node = seen.map >= 0 ? pose_count_ + seen.map : seen.pose;
      views.push_back(
          {{node, seen.axes.col(0), seen.centroid, TiltSigma(seen), 1.0 / seen.offset_weight},
           static_cast<int>(o)});
    }
  }
}

std::vector<int> NodeViews::LargestSet(const std::vector<View>& views,
                                       const std::vector<NodeState>& nodes,
                                       const std::vector<int>& part, double gate_sigmas) {
  std::vector<int> largest;
  for (const View& seed : views) {
    std::vector<int> set;
    for (std::size_t i = 0; i < views.size(); ++i) {
      const NodePlane& plane = views[i].plane;
      if (part[plane.node] != part[seed.plane.node]) continue;
      if (Agree(seed.plane, plane, nodes, gate_sigmas)) set.push_back(static_cast<int>(i));
    }
    if (set.size() > largest.size()) largest = std::move(set);
  }
  return largest;
}

std::vector<SharedLandmark> NodeViews::SharedByParts(int target, int source,
                                                     const std::vector<NodeState>& nodes,
                                                     const std::vector<int>& part,
                                                     double gate_sigmas) const {
  std::vector<SharedLandmark> shared;
  for (const auto& views : views_) {
    const auto a = PartPlane(views, target, nodes, part, gate_sigmas);
    if (!a) continue;
    const auto b = PartPlane(views, source, nodes, part, gate_sigmas);
    if (b) shared.push_back(Share(*a, *b));
  }
  return shared;
}

}  // namespace planegraph
