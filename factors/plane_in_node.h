#pragma once

#include <ceres/sized_cost_function.h>

#include <memory>
#include <string>

#include "planegraph/graph/factor_registry.h"
#include "planegraph/graph/factor_sampling.h"
#include "planegraph/graph/manifolds.h"

namespace planegraph {

/// What factors have in common that compare a landmark, as a node predicts it, with the plane that
/// was measured there: n' = R^T n and d' = e + n . (o - t), the plane n' . p = d' about the node's
/// origin, d' in metres of the world.

/// A residual of three numbers with its derivatives by n', d' and the logarithm of the node's
/// scale.
struct PlaneComparison {
  Eigen::Vector3d residual;
  Eigen::Matrix3d by_normal;
  Eigen::Vector3d by_distance, by_log_scale;
};

/// The measured plane in the node's frame: `normal` on the landmark's side when the factor was
/// made. Weights as in PlaneObservation: they belong to the tilts and to the offset at the
/// centroid.
struct MeasuredPlane {
  Eigen::Vector3d normal, axis_1, axis_2, centroid;
  double tilt_weight_1 = 1.0, tilt_weight_2 = 1.0, offset_weight = 1.0;
  double scale = 1.0;  ///< metres per unit when the factor was made; whitening is frozen there
};

inline MeasuredPlane MakeMeasuredPlane(const PlaneObservation& seen, const Eigen::Vector3d& facing,
                                       double scale) {
  const double side = seen.axes.col(0).dot(facing) < 0.0 ? -1.0 : 1.0;
  return {side * seen.axes.col(0), seen.axes.col(1),   seen.axes.col(2),   seen.centroid,
          seen.tilt_weight_1,      seen.tilt_weight_2, seen.offset_weight, scale};
}

/// A comparison by n' and by the distance g = d' - s n' . c of the predicted plane from the
/// measured centroid c (metres of the world), as one by n' and d'. `by_offset`: the derivative by
/// g.
inline PlaneComparison CompareAtCentroid(const Eigen::Vector3d& residual,
                                         const Eigen::Matrix3d& by_normal,
                                         const Eigen::Vector3d& by_offset, const Eigen::Vector3d& n,
                                         const Eigen::Vector3d& scaled_centroid) {
  return {residual, by_normal - by_offset * scaled_centroid.transpose(), by_offset,
          -n.dot(scaled_centroid) * by_offset};
}

/// The cost of a model with `PlaneComparison operator()(n', d', scale) const`.
template <typename View, typename Model>
class PlaneInNodeCost final : public ceres::SizedCostFunction<3, View::kSize, kPlaneSize> {
 public:
  PlaneInNodeCost(const Model& model, const Eigen::Vector3d& anchor)
      : model_(model), anchor_(anchor) {}

  bool Evaluate(double const* const* blocks, double* residuals, double** jacobians) const override {
    using Eigen::Vector3d;
    const View node(blocks[0]);
    const Vector3d n = Eigen::Map<const Vector3d>(blocks[1]);
    const Vector3d lever = anchor_ - node.t;
    const PlaneComparison c =
        model_(Vector3d(node.rotation.transpose() * n), blocks[1][3] + n.dot(lever), node.scale);
    Eigen::Map<Vector3d>(residuals, 3) = c.residual;
    if (jacobians == nullptr) return true;
    for (int k = 0; k < 3; ++k) {
      const Vector3d turned = node.rotation * c.by_normal.row(k).transpose();
      if (jacobians[0] != nullptr) {
        node.SetRow(-c.by_distance[k] * n, turned.cross(n), c.by_log_scale[k],
                    jacobians[0] + k * View::kSize);
      }
      if (jacobians[1] != nullptr) {
        Eigen::Map<Vector3d>(jacobians[1] + 4 * k, 3) = turned + c.by_distance[k] * lever;
        jacobians[1][4 * k + 3] = c.by_distance[k];
      }
    }
    return true;
  }

 private:
  Model model_;
  Eigen::Vector3d anchor_;
};

/// Adds the residuals of a plane's observations from poses, or from maps, to the sink.
template <typename Model>
void AddPlaneInNode(const Graph& graph, int index, const FactorOptions& options, bool maps,
                    ResidualSink* sink) {
  const PlaneLandmark& plane = graph.planes[index];
  for (int k = 0; k < static_cast<int>(plane.observations.size()); ++k) {
    const PlaneObservation& seen = plane.observations[k];
    if ((seen.map >= 0) != maps) continue;
    const Sim3 world_from_node = WorldFromObservation(graph, seen);
    const Model model(MakeMeasuredPlane(seen, world_from_node.rotation.conjugate() * plane.normal,
                                        world_from_node.scale),
                      options);
    std::unique_ptr<ceres::CostFunction> cost;
    if (maps) {
      cost = std::make_unique<PlaneInNodeCost<MapView, Model>>(model, plane.anchor);
    } else {
      cost = std::make_unique<PlaneInNodeCost<PoseView, Model>>(model, plane.anchor);
    }
    const BlockRef node =
        maps ? BlockRef{BlockKind::kMap, seen.map} : BlockRef{BlockKind::kPose, seen.pose};
    sink->Add(std::move(cost), {node, {BlockKind::kPlane, index}},
              ResidualTag{.plane = index, .observation = k}, 1.0);
  }
}

/// A random cost and state of it.
template <typename View, typename Model>
FactorSample SamplePlaneInNode(std::mt19937_64* rng) {
  FactorSampler sampler(rng);
  const PlaneLandmark plane = sampler.Landmark();
  const Sim3 map = sampler.Map();
  const Rigid3 pose(map.rotation, map.translation);
  const bool is_map = View::kSize == kMapSize;
  const Model model(
      MakeMeasuredPlane(sampler.Observation(0), map.rotation.conjugate() * plane.normal,
                        is_map ? map.scale : 1.0),
      {});
  FactorSample sample;
  sample.cost = std::make_unique<PlaneInNodeCost<View, Model>>(model, plane.anchor);
  sample.kinds = {is_map ? BlockKind::kMap : BlockKind::kPose, BlockKind::kPlane};
  sample.values = {is_map ? FactorSampler::Block(map) : FactorSampler::Block(pose),
                   FactorSampler::Block(plane)};
  return sample;
}

/// The fields that a factor reads from an observation.
inline std::vector<FactorParameter> ObservationFields() {
  return {
      {"tilt_weight_1", "1/rad", "inverse sigma of the tilt along in-plane axis 1", 1.0, true},
      {"tilt_weight_2", "1/rad", "inverse sigma of the tilt along in-plane axis 2", 1.0, true},
      {"offset_weight", "1/m", "inverse sigma of the offset at the centroid, world", 1.0, true}};
}

/// Registers the factor `type` for poses, and the same for maps as map_NAME.
template <typename Model>
void RegisterPlaneInNode(FactorType type, FactorRegistry* registry) {
  type.kind = FactorKind::kPlane;
  type.plane_blocks = true;
  type.map_counterpart = "map_" + type.name;
  const auto fields = ObservationFields();
  type.parameters.insert(type.parameters.end(), fields.begin(), fields.end());
  FactorType in_map = type;
  type.add_plane = [](const Graph& graph, int index, const FactorOptions& options,
                      ResidualSink* sink) {
    AddPlaneInNode<Model>(graph, index, options, false, sink);
  };
  type.sample = SamplePlaneInNode<PoseView, Model>;
  in_map.name = type.map_counterpart;
  in_map.kind = FactorKind::kMapPlane;
  in_map.map_counterpart.clear();
  in_map.make_manifold = nullptr;
  in_map.description += ", seen in a drone map of unknown scale";
  in_map.add_plane = [](const Graph& graph, int index, const FactorOptions& options,
                        ResidualSink* sink) {
    AddPlaneInNode<Model>(graph, index, options, true, sink);
  };
  in_map.sample = SamplePlaneInNode<MapView, Model>;
  registry->Add(std::move(type));
  registry->Add(std::move(in_map));
}

}  // namespace planegraph
