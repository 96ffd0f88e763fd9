// Plane landmark against every single point: the reference that `moments` must equal, at a cost
// that grows with the points.
//
//   r_i = w (n . (s R p_i + t - o) - e)      i = 1..N,  w = offset_weight / sqrt(N)
//
// p_i: PlaneObservation::points (node's frame); (s, R, t): world_from_node, s = 1 for a pose; n, e:
// the landmark's normal and its offset from the anchor o. With tilt weights sqrt(lambda_k) w and
// the thickness kept, the sum is that of `moments` to rounding.
#include <ceres/cost_function.h>

#include <cmath>

#include "factors/plane_in_node.h"
#include "planegraph/base/error.h"

namespace planegraph {
namespace {

using Eigen::Vector3d;
using Points = std::shared_ptr<const std::vector<Vector3d>>;

template <typename View>
class RawPointsCost final : public ceres::CostFunction {
 public:
  RawPointsCost(Points points, double weight, const Vector3d& anchor)
      : points_(std::move(points)), weight_(weight), anchor_(anchor) {
    set_num_residuals(static_cast<int>(points_->size()));
    *mutable_parameter_block_sizes() = {View::kSize, kPlaneSize};
  }

  bool Evaluate(double const* const* blocks, double* residuals, double** jacobians) const override {
    const View node(blocks[0]);
    const Vector3d n = Eigen::Map<const Vector3d>(blocks[1]), along = weight_ * n;
    for (std::size_t i = 0; i < points_->size(); ++i) {
      const Vector3d turned = node.scale * (node.rotation * (*points_)[i]);
      const Vector3d arm = turned + node.t - anchor_;
      residuals[i] = along.dot(arm) - weight_ * blocks[1][3];
      if (jacobians == nullptr) continue;
      if (jacobians[0] != nullptr) {
        node.SetRow(along, turned.cross(along), along.dot(turned), jacobians[0] + View::kSize * i);
      }
      if (jacobians[1] != nullptr) {
        Eigen::Map<Vector3d>(jacobians[1] + 4 * i, 3) = weight_ * arm;
        jacobians[1][4 * i + 3] = -weight_;
      }
    }
    return true;
  }

 private:
  Points points_;
  double weight_;
  Vector3d anchor_;
};

template <typename View>
void AddPlane(const Graph& graph, int index, const FactorOptions&, ResidualSink* sink) {
  constexpr bool kMaps = View::kSize == kMapSize;
  const PlaneLandmark& plane = graph.planes[index];
  for (int k = 0; k < static_cast<int>(plane.observations.size()); ++k) {
    const PlaneObservation& seen = plane.observations[k];
    if ((seen.map >= 0) != kMaps) continue;
    if (seen.points == nullptr || seen.points->empty()) {
      throw UsageError("the factor 'raw_points' needs observations that hold their points");
    }
    const double weight = seen.offset_weight / std::sqrt(static_cast<double>(seen.points->size()));
    sink->Add(std::make_unique<RawPointsCost<View>>(seen.points, weight, plane.anchor),
              {kMaps ? BlockRef{BlockKind::kMap, seen.map} : BlockRef{BlockKind::kPose, seen.pose},
               {BlockKind::kPlane, index}},
              ResidualTag{.plane = index, .observation = k}, 1.0);
  }
}

template <typename View>
FactorSample Sample(std::mt19937_64* rng) {
  FactorSampler sampler(rng);
  std::vector<Vector3d> points;
  for (int k = 0; k < 5; ++k) points.push_back(sampler.Point());
  const PlaneLandmark plane = sampler.Landmark();
  FactorSample sample;
  sample.cost =
      std::make_unique<RawPointsCost<View>>(std::make_shared<const std::vector<Vector3d>>(points),
                                            sampler.LogUniform(1.0, 1e3), plane.anchor);
  const bool is_map = View::kSize == kMapSize;
  sample.kinds = {is_map ? BlockKind::kMap : BlockKind::kPose, BlockKind::kPlane};
  sample.values = {
      is_map ? FactorSampler::Block(sampler.Map()) : FactorSampler::Block(sampler.Pose()),
      FactorSampler::Block(plane)};
  return sample;
}

}  // namespace

void Register_raw_points(FactorRegistry* registry) {
  FactorType type;
  type.name = "raw_points";
  type.kind = FactorKind::kPlane;
  type.description = "plane landmark against every point (the reference of `moments`; slow)";
  type.source = "point-to-plane distance, Chen and Medioni 1992";
  type.residual = "distance of each point from the landmark's plane (m of the world), weighted";
  type.parameters = {
      {"points", "m or map units", "the points themselves, node's frame", 0.0, true},
      {"offset_weight", "1/m", "inverse sigma of the mean of the distances", 1.0, true}};
  type.plane_blocks = true;
  type.map_counterpart = "map_raw_points";
  FactorType in_map = type;
  type.add_plane = AddPlane<PoseView>;
  type.sample = Sample<PoseView>;
  in_map.name = "map_raw_points";
  in_map.kind = FactorKind::kMapPlane;
  in_map.map_counterpart.clear();
  in_map.description += ", seen in a drone map of unknown scale";
  in_map.add_plane = AddPlane<MapView>;
  in_map.sample = Sample<MapView>;
  registry->Add(std::move(type));
  registry->Add(std::move(in_map));
}

}  // namespace planegraph
