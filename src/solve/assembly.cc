#include "solve/assembly.h"

#include <algorithm>
#include <cmath>

namespace planegraph {
namespace {

// rho' of a loss that carries the weight; 1 without a loss.
double LossDerivative(const ceres::LossFunction* loss, double squared_norm) {
  if (loss == nullptr) return 1.0;
  double rho[3];
  loss->Evaluate(squared_norm, rho);
  return rho[1];
}

using RowMajorMatrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

Eigen::MatrixXd ToTangent(BlockKind kind, const double* block, const RowMajorMatrix& ambient) {
  if (kind == BlockKind::kPose) {
    Eigen::Matrix<double, kPoseSize, kPoseTangent, Eigen::RowMajor> plus;
    Se3Manifold().PlusJacobian(block, plus.data());
    return ambient * plus;
  }
  if (kind == BlockKind::kMap) {
    Eigen::Matrix<double, kMapSize, kMapTangent, Eigen::RowMajor> plus;
    Sim3Manifold().PlusJacobian(block, plus.data());
    return ambient * plus;
  }
  Eigen::Matrix<double, kPlaneSize, kPlaneTangent, Eigen::RowMajor> plus;
  PlaneManifold().PlusJacobian(block, plus.data());
  return ambient * plus;
}

}  // namespace

Assembly::Assembly(const Graph& graph, const SolveOptions& options) {
  SetBlocks(graph);
  AddPlanes(graph, options);
  AddPoseFactors(graph, options);
}

void Assembly::SetBlocks(const Graph& graph) {
  poses_.resize(graph.poses.size() * kPoseSize);
  for (std::size_t i = 0; i < graph.poses.size(); ++i) {
    PoseToBlock(graph.poses[i].world_from_node, PoseBlock(static_cast<int>(i)));
  }
  planes_.resize(graph.planes.size() * kPlaneSize);
  for (std::size_t k = 0; k < graph.planes.size(); ++k) {
    double* block = PlaneBlock(static_cast<int>(k));
    Eigen::Map<Eigen::Vector3d>(block, 3) = graph.planes[k].normal.normalized();
    block[3] = graph.planes[k].offset;
  }
  maps_.resize(graph.maps.size() * kMapSize);
  for (std::size_t m = 0; m < graph.maps.size(); ++m) {
    MapToBlock(graph.maps[m].world_from_map, MapBlock(static_cast<int>(m)));
  }
}

void Assembly::AddPlanes(const Graph& graph, const SolveOptions& options) {
  const FactorType& type = BuiltinFactors().Get(options.plane_factor, FactorKind::kPlane);
  type.CheckOptions(options.plane_factor_options);
  plane_blocks_ = type.plane_blocks;
  std::size_t observations = 0;
  for (const PlaneLandmark& plane : graph.planes) observations += plane.observations.size();
  residuals_.reserve(observations + graph.pose_factors.size());
  losses_.push_back(MakeLoss(options.plane_loss));
  present_loss_ = losses_.back().get();
  for (int k = 0; k < static_cast<int>(graph.planes.size()); ++k) {
    type.add_plane(graph, k, options.plane_factor_options, this);
  }
  if (graph.maps.empty()) return;
  const FactorType& in_maps = BuiltinFactors().MapPlaneFactorFor(type);
  for (int k = 0; k < static_cast<int>(graph.planes.size()); ++k) {
    in_maps.add_plane(graph, k, {}, this);
  }
}

void Assembly::AddMapFactors(const Graph& graph, const ceres::LossFunction* robust) {
  for (int k = 0; k < static_cast<int>(graph.map_factors.size()); ++k) {
    const MapFactor& factor = graph.map_factors[k];
    const FactorType& type = BuiltinFactors().Get(factor.type, FactorKind::kMap);
    present_loss_ = factor.robust ? robust : nullptr;
    const ResidualTag tag{.map_factor = k};
    const BlockRef first{BlockKind::kMap, factor.maps[0]};
    if (factor.maps.size() == 1) {
      Add(type.make_map_cost(factor), {first}, tag, 1.0);
    } else {
      Add(type.make_map_cost(factor), {first, {BlockKind::kMap, factor.maps[1]}}, tag, 1.0);
    }
  }
}

void Assembly::AddPoseFactors(const Graph& graph, const SolveOptions& options) {
  losses_.push_back(MakeLoss(options.pose_loss));
  const ceres::LossFunction* robust = losses_.back().get();
  for (int k = 0; k < static_cast<int>(graph.pose_factors.size()); ++k) {
    const PoseFactor& factor = graph.pose_factors[k];
    const FactorType& type = BuiltinFactors().Get(factor.type, FactorKind::kPose);
    present_loss_ = factor.robust ? robust : nullptr;
    const ResidualTag tag{.pose_factor = k};
    const BlockRef first{BlockKind::kPose, factor.poses[0]};
    if (factor.poses.size() == 1) {
      Add(type.make_cost(factor), {first}, tag, 1.0);
    } else {
      Add(type.make_cost(factor), {first, {BlockKind::kPose, factor.poses[1]}}, tag, 1.0);
    }
  }
  AddMapFactors(graph, robust);
}

void Assembly::Add(std::unique_ptr<ceres::CostFunction> cost,
                   std::initializer_list<BlockRef> blocks, const ResidualTag& tag, double weight) {
  Residual& residual = residuals_.emplace_back();
  residual.cost = std::move(cost);
  std::copy(blocks.begin(), blocks.end(), residual.blocks.begin());
  residual.block_count = static_cast<int>(blocks.size());
  residual.tag = tag;
  residual.weight = weight;
  residual.loss = LossFor(weight);
}

// One loss object per kernel and weight: the weights 2/k take few values.
ceres::LossFunction* Assembly::LossFor(double weight) {
  if (present_loss_ == nullptr && weight == 1.0) return nullptr;
  ceres::LossFunction*& loss = scaled_losses_[{present_loss_, weight}];
  if (loss == nullptr) {
    losses_.push_back(
        std::make_unique<ceres::ScaledLoss>(present_loss_, weight, ceres::DO_NOT_TAKE_OWNERSHIP));
    loss = losses_.back().get();
  }
  return loss;
}

double* Assembly::Block(const BlockRef& block) {
  if (block.kind == BlockKind::kMap) return MapBlock(block.index);
  return block.kind == BlockKind::kPose ? PoseBlock(block.index) : PlaneBlock(block.index);
}

double Assembly::Chi2(const Residual& residual, double* weight) {
  constexpr int kMaxResiduals = 16;
  Eigen::Matrix<double, Eigen::Dynamic, 1, 0, kMaxResiduals, 1> r(residual.cost->num_residuals());
  const double* blocks[2] = {Block(residual.blocks[0]), Block(residual.blocks[1])};
  residual.cost->Evaluate(blocks, r.data(), nullptr);
  const double chi2 = r.squaredNorm();
  if (weight != nullptr) *weight = LossDerivative(residual.loss, chi2);
  return chi2;
}

void Assembly::Linearize(const Residual& residual, LinearizedResidual* out) {
  const int rows = residual.cost->num_residuals();
  out->residual.resize(rows);
  std::array<RowMajorMatrix, 2> ambient;
  const double* blocks[2] = {nullptr, nullptr};
  double* jacobians[2] = {nullptr, nullptr};
  for (int k = 0; k < residual.block_count; ++k) {
    ambient[k].resize(rows, residual.cost->parameter_block_sizes()[k]);
    blocks[k] = Block(residual.blocks[k]);
    jacobians[k] = ambient[k].data();
  }
  residual.cost->Evaluate(blocks, out->residual.data(), jacobians);
  const double scale = std::sqrt(LossDerivative(residual.loss, out->residual.squaredNorm()));
  out->residual *= scale;
  for (int k = 0; k < residual.block_count; ++k) {
    out->jacobians[k] = scale * ToTangent(residual.blocks[k].kind, blocks[k], ambient[k]);
  }
}

void Assembly::Store(Graph* graph) const {
  for (std::size_t i = 0; i < graph->poses.size(); ++i) {
    graph->poses[i].world_from_node = PoseFromBlock(&poses_[kPoseSize * i]);
  }
  for (std::size_t k = 0; k < graph->planes.size(); ++k) {
    const double* block = &planes_[kPlaneSize * k];
    graph->planes[k].normal = Eigen::Map<const Eigen::Vector3d>(block).normalized();
    graph->planes[k].offset = block[3];
  }
  for (std::size_t m = 0; m < graph->maps.size(); ++m) {
    graph->maps[m].world_from_map = MapFromBlock(&maps_[kMapSize * m]);
  }
}

Gauge GaugeFixed(const Graph& graph, bool count_priors) {
  Gauge gauge;
  for (const PoseNode& node : graph.poses) gauge.poses.push_back(node.fixed);
  for (const MapNode& node : graph.maps) gauge.maps.push_back(node.fixed);
  bool has_prior = false;
  for (const MapFactor& factor : graph.map_factors) {
    if (factor.maps.size() != 1) continue;
    has_prior = true;
    if (!count_priors) gauge.maps[factor.maps[0]] = true;
  }
  const auto held = [](const std::vector<bool>& fixed) {
    return std::find(fixed.begin(), fixed.end(), true) != fixed.end();
  };
  if (gauge.poses.empty() || held(gauge.poses) || held(gauge.maps)) return gauge;
  const auto prior =
      std::find_if(graph.pose_factors.begin(), graph.pose_factors.end(),
                   [](const PoseFactor& factor) { return factor.poses.size() == 1; });
  const bool has_pose_prior = prior != graph.pose_factors.end();
  if (!has_pose_prior && !has_prior) gauge.poses[0] = true;
  if (has_pose_prior && !count_priors) gauge.poses[prior->poses[0]] = true;
  return gauge;
}

}  // namespace planegraph
